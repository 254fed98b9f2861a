#include "client/import/source_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "absl/strings/str_cat.h"
#include "tests/unit/import/temp_folder.h"

namespace penumbra {
namespace {

using absl::StatusCode;

class SourceFile : public testing::Test {
 protected:
  SourceFile() {
    folder_.Write("secret.bin", "secret");
    folder_.Write("scene/a b.bin", "blank");
    folder_.Write("scene/sub/c%20d.bin", "percent");
    std::filesystem::create_symlink(folder_.path() / "secret.bin", scene() / "link.bin");
    std::filesystem::create_symlink(scene() / "a b.bin", scene() / "inner.bin");
  }
  std::filesystem::path scene() const { return folder_.path() / "scene"; }
  absl::StatusOr<std::string> Read(std::string_view uri) const {
    const auto bytes = ReadUri(scene(), uri, "buffers[0].uri");
    if (!bytes.ok()) return bytes.status();
    return std::string(AsText(*bytes));
  }

  TempFolder folder_;
};

TEST_F(SourceFile, NamesMayBePercentEncodedAndHoldBlanks) {
  EXPECT_EQ(Read("a%20b.bin").value(), "blank");
  EXPECT_EQ(Read("a b.bin").value(), "blank");
  EXPECT_EQ(Read("./sub/../a b.bin").value(), "blank");
  EXPECT_EQ(Read("sub/c%2520d.bin").value(), "percent");
  EXPECT_EQ(Read("inner.bin").value(), "blank");
}

TEST_F(SourceFile, E17WhatLeavesTheFolderIsRefused) {
  const std::string absolute = (folder_.path() / "secret.bin").string();
  for (const std::string& uri :
       {std::string("../secret.bin"), std::string("%2e%2e/secret.bin"),
        std::string("sub/../../secret.bin"), absolute, absl::StrCat("file://", absolute),
        std::string("https://example.org/a.bin"), std::string("..\\secret.bin"),
        std::string("link.bin"), std::string("..")}) {
    const auto text = Read(uri);
    EXPECT_EQ(text.status().code(), StatusCode::kPermissionDenied) << uri << text.status();
    EXPECT_THAT(std::string(text.status().message()), testing::HasSubstr("buffers[0].uri")) << uri;
  }
}

TEST_F(SourceFile, DataUrisAreDecoded) {
  EXPECT_EQ(Read("data:application/octet-stream;base64,aGVsbG8=").value(), "hello");
  EXPECT_EQ(Read("data:,a%20b").value(), "a b");
  EXPECT_EQ(Read("data:;base64,!!").status().code(), StatusCode::kInvalidArgument);
  EXPECT_EQ(Read("data:nothing").status().code(), StatusCode::kInvalidArgument);
}

TEST_F(SourceFile, MissingFilesAndFoldersAreErrors) {
  EXPECT_EQ(Read("nowhere.bin").status().code(), StatusCode::kNotFound);
  EXPECT_EQ(Read("sub").status().code(), StatusCode::kInvalidArgument);
  EXPECT_EQ(Read("").status().code(), StatusCode::kInvalidArgument);
  EXPECT_EQ(Read(std::string_view("a\0b", 3)).status().code(), StatusCode::kInvalidArgument);
  EXPECT_EQ(ImportScene(scene() / "no.glb").status().code(), StatusCode::kNotFound);
  EXPECT_EQ(ImportScene(scene()).status().code(), StatusCode::kInvalidArgument);
}

TEST_F(SourceFile, UnknownKindsAreNamed) {
  const auto scene = ImportBytes("notes.txt", "hello");
  EXPECT_EQ(scene.status().code(), StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(scene.status().message()),
              testing::HasSubstr("notes.txt: found an unknown kind of file"));
}

}  // namespace
}  // namespace penumbra
