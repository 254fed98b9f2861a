#include "server/security/identity_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "absl/strings/str_cat.h"
#include "absl/time/time.h"
#include "render/scene/field_error.h"
#include "server/security/base64url.h"
#include "server/security/bearer_token.h"

namespace penumbra {
namespace {

using ::testing::HasSubstr;

std::string LineFor(const std::string& token, const std::string& rest) {
  return absl::StrCat("token sha256:", HashOfToken(token).hex(), " ", rest, "\n");
}

TEST(BearerTokenTest, TokensDifferAndHave256Bits) {
  const std::string token = MakeBearerToken();
  EXPECT_NE(token, MakeBearerToken());
  ASSERT_TRUE(IsBearerToken(token)) << token;
  EXPECT_EQ(DecodeBase64Url(token.substr(9))->size(), 32u);
  for (const std::string& other : {std::string(), std::string("penumbra_"), token.substr(1),
                                   token + "A", token.substr(0, token.size() - 4), token + "=",
                                   token + " ", std::string("penumbra_password")}) {
    EXPECT_FALSE(IsBearerToken(other)) << other;
  }
}

TEST(Base64UrlTest, EachTextOfBytesHasOneSpelling) {
  EXPECT_EQ(DecodeBase64Url("AQI"), "\x01\x02");
  EXPECT_EQ(DecodeBase64Url(""), "");
  EXPECT_EQ(DecodeBase64Url("-_-_"), "\xfb\xff\xbf");
  // Bits left over, padding, blanks, the other alphabet, a length that there is none of.
  for (const char* bad : {"AQJ", "AQI=", "A QI", "+/+/", "A", "AQI\n", "\xff\xff\xff\xff"}) {
    EXPECT_EQ(DecodeBase64Url(bad), std::nullopt) << bad;
  }
}

TEST(IdentityFileTest, FindsWhomTheLinesName) {
  const std::string ana = MakeBearerToken(), ben = MakeBearerToken();
  const auto file = IdentityFile::Parse(
      "# who      what\n\n" + LineFor(ana, "ana editor review-*,studio 2027-01-31T00:00:00Z") +
      "  " + LineFor(ben, "\t ben  viewer *") + "certificate cn:render-01 farm admin *\r\n");
  ASSERT_TRUE(file.ok()) << file.status();
  EXPECT_EQ(file->size(), 3u);
  const Identity* found = file->FindToken(ana);
  ASSERT_NE(found, nullptr);
  EXPECT_EQ(found->name, "ana");
  EXPECT_EQ(found->role, Role::kEditor);
  EXPECT_TRUE(found->scope.Contains("review-1"));
  EXPECT_FALSE(found->scope.Contains("other"));
  EXPECT_EQ(found->expires, absl::ToChronoTime(absl::FromUnixSeconds(1'801'353'600)));
  ASSERT_NE(file->FindToken(ben), nullptr);
  EXPECT_EQ(file->FindToken(ben)->expires, std::nullopt);
  EXPECT_EQ(file->FindToken(MakeBearerToken()), nullptr);
  EXPECT_EQ(file->FindToken(""), nullptr);
  const std::vector<std::string> names = {"dns:render-01", "cn:render-01"};
  ASSERT_NE(file->FindCertificate(names), nullptr);
  EXPECT_EQ(file->FindCertificate(names)->name, "farm");
  // A name of another kind, and one that goes on behind a NUL, are other names.
  EXPECT_EQ(file->FindCertificate(std::vector<std::string>{"dns:render-01"}), nullptr);
  EXPECT_EQ(file->FindCertificate(std::vector<std::string>{std::string("cn:render-01\0x", 14)}),
            nullptr);
}

TEST(IdentityFileTest, SaysWhichLineIsWrongAndNeverWhatTheTokenIs) {
  const std::string token = MakeBearerToken();
  const std::string good = LineFor(token, "ana editor *");
  const std::pair<std::string, const char*> cases[] = {
      {"token " + token + " ana editor *", "sha256:"},
      {"token sha256:1234 ana editor *", "sha256:"},
      {LineFor(token, "ana owner *"), "role 'owner'"},
      {LineFor(token, "a/b editor *"), "found"},
      {LineFor(token, "ana editor rev/*"), "rev/*"},
      {LineFor(token, "ana editor * tomorrow"), "'tomorrow'"},
      {LineFor(token, "ana editor"), "words"},
      {LineFor(token, "ana editor * 2027-01-31T00:00:00Z more"), "words"},
      {"password sha256:x ana editor *", "'password'"},
      {"certificate render-01 farm viewer *", "cn:"},
      {"certificate cn: farm viewer *", "cn:"},
      {good + good, "second time"},
      {"certificate cn:a farm viewer *\ncertificate cn:a farm admin *", "second time"},
  };
  for (const auto& [text, fragment] : cases) {
    const auto status = IdentityFile::Parse("#\n" + text).status();
    EXPECT_EQ(ErrorReason(status), "BAD_IDENTITY") << text;
    EXPECT_THAT(ErrorFieldPath(status), ::testing::MatchesRegex("tokens:[23]")) << text;
    EXPECT_THAT(std::string(status.message()), HasSubstr(fragment)) << text;
    EXPECT_THAT(std::string(status.message()), Not(HasSubstr(token)));
  }
}

TEST(IdentityFileTest, IsBounded) {
  std::string text;
  for (int i = 0; i < 1'025; ++i) absl::StrAppend(&text, "certificate cn:", i, " farm viewer *\n");
  EXPECT_EQ(ErrorFieldPath(IdentityFile::Parse(text).status()), "tokens:1025");
}

}  // namespace
}  // namespace penumbra
