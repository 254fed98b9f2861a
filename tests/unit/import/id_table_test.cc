#include "client/import/id_table.h"

#include <gtest/gtest.h>

#include "render/scene/scene.h"

namespace penumbra {
namespace {

TEST(IdTable, KeepsAllowedLettersAndReplacesOthers) {
  IdTable ids;
  EXPECT_EQ(ids.Add("Oak table/1"), "Oak_table_1");
  EXPECT_EQ(ids.Add("a.B-9_z"), "a.B-9_z");
}

TEST(IdTable, MakesNamesUnique) {
  IdTable ids;
  EXPECT_EQ(ids.Add("leg"), "leg");
  EXPECT_EQ(ids.Add("leg"), "leg-2");
  EXPECT_EQ(ids.Add("leg-3"), "leg-3");
  EXPECT_EQ(ids.Add("leg"), "leg-4");
}

TEST(IdTable, AnyBytesMakeAValidId) {
  IdTable ids;
  for (const std::string& name :
       {std::string(), std::string("\0\n", 2), std::string("日本"), std::string(1'000'000, 'x'),
        std::string(1'000'000, 'x'), std::string("../..")}) {
    const std::string id = ids.Add(name, "node");
    EXPECT_TRUE(CheckId(id, "id").ok()) << id;
  }
}

}  // namespace
}  // namespace penumbra
