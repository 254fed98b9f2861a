#include "client/cli/people.h"

#include <gtest/gtest.h>
#include <pwd.h>
#include <stdlib.h>
#include <unistd.h>

namespace penumbra {
namespace {

TEST(PresenceOfTest, ANameIsTheLoginNameWhereverThatIsTold) {
  ASSERT_EQ(setenv("USER", "ada", 1), 0);
  ASSERT_EQ(setenv("LOGNAME", "bob", 1), 0);
  EXPECT_EQ(PresenceOf({}).display_name, "ada");
  EXPECT_EQ(PresenceOf({.name = "Cid"}).display_name, "Cid");
  ASSERT_EQ(setenv("USER", "", 1), 0);
  EXPECT_EQ(PresenceOf({}).display_name, "bob");
  ASSERT_EQ(unsetenv("LOGNAME"), 0);
  const passwd* const entry = getpwuid(getuid());
  EXPECT_EQ(PresenceOf({}).display_name, entry != nullptr ? entry->pw_name : "somebody");
}

}  // namespace
}  // namespace penumbra
