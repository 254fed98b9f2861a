#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/unit/import/temp_folder.h"

namespace penumbra {
namespace {

using absl::StatusCode;
using testing::ElementsAre;
using testing::HasSubstr;

constexpr char kHeader[] =
    "ply\nformat ascii 1.0\ncomment made by hand\nelement vertex 4\nproperty float x\n"
    "property float y\nproperty float z\nelement face 1\n"
    "property list uchar int vertex_indices\nend_header\n";
constexpr char kVertices[] = "0 0 0\n1 0 0\n1 1 0\n0 1 0.5\n";

absl::Status StatusOf(const std::string& bytes) { return ImportBytes("a.ply", bytes).status(); }

TEST(Ply, PolygonsBecomeFans) {
  const auto scene = ImportBytes("my mesh.ply", std::string(kHeader) + kVertices + "4 0 1 2 3\n");
  ASSERT_TRUE(scene.ok()) << scene.status();
  const Instance instance = InstanceOf(*scene, "my_mesh");
  EXPECT_THAT(instance.mesh->indices(), ElementsAre(0, 1, 2, 0, 2, 3));
  EXPECT_EQ(instance.mesh->positions()[3], Vec3(0, 1, 0.5f));
}

// The corpus holds one pyramid in three encodings.
TEST(Ply, EncodingsAgree) {
  const std::filesystem::path corpus(PENUMBRA_CORPUS);
  const auto ascii = ImportScene(corpus / "ascii.ply");
  ASSERT_TRUE(ascii.ok()) << ascii.status();
  EXPECT_EQ(ascii->instances[0].mesh->positions()[4], Vec3(0, 1.5f, 0));
  for (const char* name : {"little.ply", "big.ply"}) {
    const auto binary = ImportScene(corpus / name);
    ASSERT_TRUE(binary.ok()) << binary.status();
    EXPECT_EQ(binary->instances[0].mesh->id(), ascii->instances[0].mesh->id()) << name;
  }
}

TEST(Ply, CarriageReturnsEndLinesToo) {
  for (const char* line_end : {"\r\n", "\r"}) {
    std::string text = std::string(kHeader) + kVertices + "3 0 1 2\n";
    for (size_t at = 0; (at = text.find('\n', at)) != std::string::npos;
         at += std::string_view(line_end).size()) {
      text.replace(at, 1, line_end);
    }
    EXPECT_TRUE(StatusOf(text).ok()) << StatusOf(text);
  }
}

TEST(Ply, ErrorsNameTheirPlace) {
  const std::string header = kHeader;
  const auto without = [&header](const std::string& line) {
    std::string text = header;
    return text.erase(text.find(line), line.size());
  };
  const std::string body = std::string(kVertices) + "3 0 1 2\n";
  const std::pair<std::string, const char*> cases[] = {
      {"ply\n", "header line 2: found the end of the file"},
      {without("format ascii 1.0\n") + body, "header: found no format line"},
      {without("property float y\n") + body, "element vertex: found no x, y and z"},
      {header, "\"vertex\"[0].x: found the end of the file"},
      {header + "0 0 zero\n", "\"vertex\"[0].z"},
      {header + kVertices + "3 0 1\n", "\"face\"[0].vertex_indices"},
      {header + kVertices + "3 0 1 -2\n", "face[0].vertex_indices[2]: found -2"},
      {header + kVertices + "3 0 1 4\n", "indices[2]: found 4"},
      {header + "0 0 nan\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2\n", "positions[0]"},
      {"ply\nformat ascii 2.0\n", "header line 2"},
      {"ply\nformat ascii 1.0\nelement vertex 4000000000\nproperty float x\nend_header\n",
       "header line 3"},
      {"ply\nformat ascii 1.0\nelement vertex 3\nend_header\n", "found no properties"}};
  for (const auto& [text, fragment] : cases) {
    const absl::Status status = StatusOf(text);
    EXPECT_EQ(status.code(), StatusCode::kInvalidArgument) << fragment;
    EXPECT_THAT(std::string(status.message()), HasSubstr(fragment));
  }
}

TEST(Ply, AListLongerThanTheFileEndsWithIt) {
  std::string text =
      "ply\nformat binary_little_endian 1.0\nelement vertex 1\nproperty float x\n"
      "property float y\nproperty float z\nelement face 1\n"
      "property list uint int vertex_indices\nend_header\n";
  text += std::string(12, '\0') + "\xff\xff\xff\xff" + std::string(8, '\0');
  EXPECT_THAT(std::string(StatusOf(text).message()), HasSubstr("\"face\"[0].vertex_indices"));
}

TEST(Ply, LimitsAreKept) {
  const TempFolder folder;
  const auto scene =
      ImportScene(folder.Write("a.ply", std::string(kHeader) + kVertices + "4 0 1 2 3\n"),
                  {.max_vertices_per_mesh = 3});
  EXPECT_EQ(scene.status().code(), StatusCode::kResourceExhausted);
  EXPECT_THAT(std::string(scene.status().message()), HasSubstr("element vertex: found 4"));
}

}  // namespace
}  // namespace penumbra
