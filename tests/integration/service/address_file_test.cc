// The file that says where a server listens: it is there as long as that server does.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "tests/integration/service/wire_client.h"
#include "tests/support/daemon.h"

namespace penumbra::testing {
namespace {

// Where nobody listens any more, on a port that any user may listen on.
std::string AddressOfNobody() {
  Daemon killed({"--listen", "127.0.0.1:0"});
  return killed.Address();
}

class AddressFileTest : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string name = std::filesystem::temp_directory_path() / "penumbra-address-XXXXXX";
    ASSERT_NE(mkdtemp(name.data()), nullptr);
    folder_ = name;
    file_ = folder_ / "address";
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::vector<std::string> Words(const std::string& listen = "127.0.0.1:0") {
    return {"--listen", listen, "--address-file", file_, "--drain-seconds", "20"};
  }
  std::string Text() {
    std::string line;
    std::ifstream file(file_);
    std::getline(file, line);
    return line;
  }

  std::filesystem::path folder_;
  std::filesystem::path file_;
};

TEST_F(AddressFileTest, GoesWithTheServer) {
  Daemon daemon(Words());
  EXPECT_EQ(Text(), daemon.Address());
  daemon.Signal(SIGTERM);
  EXPECT_EQ(daemon.Wait(), 0);
  EXPECT_TRUE(is_empty(folder_));
}

TEST_F(AddressFileTest, IsWrittenWhereALinkLeads) {
  std::filesystem::create_symlink("elsewhere", file_);  // which is yet to be made
  Daemon daemon(Words());
  EXPECT_EQ(Text(), daemon.Address());
  EXPECT_TRUE(is_symlink(file_));
  EXPECT_TRUE(exists(folder_ / "elsewhere"));
}

TEST_F(AddressFileTest, OfALiveServerStaysWhenAnotherCannotStart) {
  Daemon first(Words());
  const std::string address = first.Address();
  Daemon second(Words(address));
  EXPECT_EQ(second.Wait(), EXIT_FAILURE);
  EXPECT_EQ(Text(), address);
}

TEST_F(AddressFileTest, OfTheNextServerOutlivesTheOneThatDrains) {
  Daemon first(Words());
  WireClient client(first.Address());
  grpc::ClientContext context;
  v1::UploadBlobResponse response;
  const auto silent = client.stub().UploadBlob(&context, &response);
  ASSERT_EQ(client.CreateScene("studio"), absl::OkStatus());
  first.Signal(SIGTERM);
  Daemon second(Words());
  const std::string address = second.Address();
  EXPECT_EQ(Text(), address);
  context.TryCancel();
  EXPECT_FALSE(silent->Finish().ok());
  EXPECT_EQ(first.Wait(), 0);
  EXPECT_EQ(Text(), address);
}

TEST_F(AddressFileTest, OfADeadServerSendsNobodyThere) {
  std::ofstream(file_) << AddressOfNobody() << "\n";
  Daemon one_that_lives({"--listen", "127.0.0.1:0"});
  Daemon cannot_start(Words(one_that_lives.Address()));
  EXPECT_EQ(cannot_start.Wait(), EXIT_FAILURE);
  EXPECT_FALSE(exists(file_));
  std::ofstream(file_) << AddressOfNobody() << "\n";
  Daemon daemon(Words());
  EXPECT_EQ(Text(), daemon.Address());
}

TEST_F(AddressFileTest, ThatCannotBeWrittenIsAnErrorOnOneLine) {
  file_ = folder_ / "no-such-folder" / "address";
  Daemon daemon(Words());
  EXPECT_THAT(daemon.ErrorLine(), ::testing::HasSubstr("started"));
  EXPECT_THAT(daemon.ErrorLine(), ::testing::HasSubstr("address-file: cannot write"));
  EXPECT_EQ(daemon.Wait(), EXIT_FAILURE);
}

}  // namespace
}  // namespace penumbra::testing
