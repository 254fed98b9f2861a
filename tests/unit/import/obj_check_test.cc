// Broken OBJ files: what is said of them, and that nothing sound is refused with them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "absl/strings/str_cat.h"
#include "render/scene/field_error.h"
#include "tests/unit/import/temp_folder.h"

namespace penumbra {
namespace {

using absl::StatusCode;
using testing::HasSubstr;

// Four vertices, the corners of a square of area 2.
constexpr char kSquare[] = "v 0 0 0\nv 2 0 0\nv 2 1 0\nv 0 1 0\n";

void ExpectRefused(const std::string& obj, const char* reason, const std::string& message) {
  const auto scene = ImportBytes("a.obj", obj);
  EXPECT_EQ(scene.status().code(), StatusCode::kInvalidArgument) << obj;
  EXPECT_EQ(ErrorReason(scene.status()), reason) << obj;
  EXPECT_THAT(std::string(scene.status().message()), HasSubstr(message)) << obj;
}

void ExpectFaceRefused(const std::string& face, const char* reason, const std::string& message) {
  ExpectRefused(kSquare + face + "\n", reason, absl::StrCat("line 5: f: found ", message));
}

double AreaOf(const ImportedScene& scene) {
  double area = 0.0;
  for (const Instance& instance : scene.instances) {
    const auto p = instance.mesh->positions();
    const auto i = instance.mesh->indices();
    for (size_t t = 0; t < i.size(); t += 3) {
      area += 0.5 * glm::length(glm::cross(p[i[t + 1]] - p[i[t]], p[i[t + 2]] - p[i[t]]));
    }
  }
  return area;
}

void ExpectArea(const std::string& obj, double area) {
  const auto scene = ImportBytes("a.obj", obj);
  ASSERT_TRUE(scene.ok()) << obj << scene.status();
  EXPECT_NEAR(AreaOf(*scene), area, 1e-6) << obj;
}

TEST(ObjCheck, NumbersThatAreNotFiniteAreRefused) {
  const std::string need = ", need three finite numbers";
  ExpectRefused("v 0 nan 0\n", "NON_FINITE", "line 1: v: found \"nan\"" + need);
  ExpectRefused("v 1 inf 0\n", "NON_FINITE", "line 1: v: found \"inf\"" + need);
  ExpectRefused("v 0 0 -Infinity\n", "NON_FINITE", "line 1: v: found \"-Infinity\"" + need);
  ExpectRefused("v 0 1e999 0\n", "NON_FINITE", "line 1: v: found \"1e999\"" + need);
  ExpectRefused("vn NaN 0 1\n", "NON_FINITE", "line 1: vn: found \"NaN\"" + need);
  ExpectRefused("vt 0 nan\n", "NON_FINITE", "line 1: vt: found \"nan\", need one or two");
}

TEST(ObjCheck, WordsThatAreNoNumbersAreRefused) {
  for (const char* word : {"zero", "1,5", "0x10", "1e", "--1", "+-1", "1\\", "."}) {
    ExpectRefused(absl::StrCat("v 1 ", word, " 0\n"), "MALFORMED", "line 1: v: found \"");
  }
  ExpectRefused("v 1 2 \\\n3\n", "MALFORMED", "line 1: v: found");
}

TEST(ObjCheck, TooFewNumbersAreRefused) {
  ExpectRefused("v 0 0\n", "MALFORMED", "line 1: v: found 2 numbers, need three");
  ExpectRefused("v\n", "MALFORMED", "line 1: v: found 0 numbers");
  ExpectRefused("v 0 0 # 0\n", "MALFORMED", "line 1: v: found 2 numbers");
  ExpectRefused("vn 0 1\n", "MALFORMED", "line 1: vn: found 2 numbers");
  ExpectRefused("vt\n", "MALFORMED", "line 1: vt: found 0 numbers, need one or two");
}

TEST(ObjCheck, ATagIsHeldToWhatItPromises) {
  ExpectArea(
      absl::StrCat(kSquare, "f 1 2 3 4\nt crease 2/1/0 1 2 4.7\nt interpolateboundary 1 1\n"), 2.0);
  ExpectRefused("t crease 2/1/0 1 2\n", "MALFORMED",
                "line 1: t: found 2 values after \"2/1/0\", need 3");
  ExpectRefused("t x 8192/8192/8192\n", "MALFORMED", "need 24576");
  ExpectRefused("t x 99999999999999/99999999999999/1 1\n", "MALFORMED", "line 1: t: found 1");
  ExpectRefused("t x 1/a 1\n", "MALFORMED", "line 1: t: found \"1/a\"");
}

TEST(ObjCheck, NumbersOutOfBoundsAreRefused) {
  ExpectRefused("v 0 -1e30 0\n", "OUT_OF_BOUNDS", "line 1: v: found \"-1e30\", need at most 1e+09");
}

TEST(ObjCheck, LinesAreCountedWhateverTheirEnd) {
  for (const char* end : {"\n", "\r\n", "\r"}) {
    ExpectRefused(absl::StrCat("# a", end, end, "v 0 0 0", end, "\t v x 0 0", end), "MALFORMED",
                  "line 4: v: found \"x\"");
  }
}

TEST(ObjCheck, IndicesOfNothingAreRefused) {
  for (const char* index : {"0", "5", "-5", "2147483648", "4294967297", "99999999999999999999",
                            "-9223372036854775808"}) {
    ExpectFaceRefused(absl::StrCat("f 1 2 ", index), "INDEX_RANGE",
                      absl::StrCat("\"", index, "\", need one of the 4 v so far"));
  }
  ExpectFaceRefused("f 1/1 2/1 3/1", "INDEX_RANGE", "\"1/1\", need one of the 0 vt so far");
  ExpectFaceRefused("f 1//1 2//1 3//1", "INDEX_RANGE", "\"1//1\", need one of the 0 vn so far");
  ExpectRefused("f 1 2 3\n" + std::string(kSquare), "INDEX_RANGE", "line 1: f: found \"1\"");
  ExpectRefused(std::string(kSquare) + "vt 0 0\nf 1/1 2/2 3/1\n", "INDEX_RANGE",
                "line 6: f: found \"2/2\", need one of the 1 vt so far");
}

TEST(ObjCheck, CornersThatAreNoIndicesAreRefused) {
  for (const char* corner : {"a", "1.5", "3/", "3//", "/3", "3/1/1/1", "#"}) {
    const std::string obj = absl::StrCat(kSquare, "vt 0 0\nvn 0 0 1\nf 1 2 ", corner, "\n");
    ExpectRefused(obj, "MALFORMED",
                  absl::StrCat("line 7: f: found \"", corner, "\", need v, v/vt"));
  }
}

TEST(ObjCheck, FacesOfFewerThanThreeCornersAreRefused) {
  ExpectFaceRefused("f 1 2", "MALFORMED", "2 corners, need at least 3");
  ExpectFaceRefused("f", "MALFORMED", "0 corners");
}

TEST(ObjCheck, EveryWayToWriteASoundFilePasses) {
  const std::string square = kSquare;
  ExpectArea(square + "f 1 2 3 4", 2.0);
  ExpectArea(square + "f -4 -3 -2 -1 \n", 2.0);
  ExpectArea(square + "vt 0\nvn 0 0 1\nf 1/1/1 2//1 -2/-1 +4\n", 2.0);
  ExpectArea("v\t+0. -.0 0e5\nv 2 0 1e-400 # w\nv 20e-1 1 0 1.0\nv 0 1 0 1 0.5 nan\nf 1 2 3 4\n",
             2.0);
  ExpectArea(square + "l 1 9\ncurv nan\nf 1 2 3\n", 1.0);
  std::string with_carriage_returns = square + "f 1 2 3 4\n";
  std::replace(with_carriage_returns.begin(), with_carriage_returns.end(), '\n', '\r');
  ExpectArea(with_carriage_returns, 2.0);
}

TEST(ObjCheck, EveryPrefixOfAFileIsASceneOrAnError) {
  const std::string whole =
      std::string(kSquare) + "vt 0 1\nvn 0 0 1\no a\nf 1/1/1 2/1/1 3/1/1 4/1/1\n";
  for (size_t size = 0; size <= whole.size(); ++size) {
    const auto scene = ImportBytes("a.obj", whole.substr(0, size));
    if (!scene.ok()) {
      EXPECT_EQ(scene.status().code(), StatusCode::kInvalidArgument) << size;
    }
  }
}

}  // namespace
}  // namespace penumbra
