// SPDX-License-Identifier: Apache-2.0
#include "drivers/support/key_file.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include "tests/fakes/scratch_folder.hpp"

namespace srd {
namespace {

constexpr const char* kDigits = "00112233445566778899aabbccddeeff00112233445566778899aabbccddeeff";

std::filesystem::path written(const fakes::ScratchFolder& folder, const std::string& text, mode_t mode = 0600) {
  const auto file = folder.write("n.key", text);
  EXPECT_EQ(::chmod(file.c_str(), mode), 0);
  return file;
}

TEST(KeyFile, ComesBackAsItWasWritten) {
  const fakes::ScratchFolder folder;
  const KeyFile made{"cam-1", {SecretBytes::random(), SecretBytes::random()}};
  EXPECT_FALSE(made.keys[0] == made.keys[1]);
  const auto file = folder.path() / "cam-1.key";
  ASSERT_TRUE(made.write(file).ok());
  ASSERT_TRUE(made.write(file).ok()) << "in place of the one that is there";
  struct stat info {};
  ASSERT_EQ(::stat(file.c_str(), &info), 0);
  EXPECT_EQ(info.st_mode & 0777, 0600U);
  const auto read = KeyFile::read(file);
  ASSERT_TRUE(read.ok()) << read.error().text();
  EXPECT_EQ(read->node, "cam-1");
  EXPECT_TRUE(read->keys == made.keys);
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path()), {}), 1);
}

TEST(KeyFile, IsReadWithCommentsAndEitherCase) {
  const fakes::ScratchFolder folder;
  std::string upper = kDigits;
  for (char& c : upper) c = static_cast<char>(std::toupper(c));
  const auto read = KeyFile::read(written(folder, "# of the flume\n\n  flume-srd-key-1 n " + upper + "  \r\n", 0400));
  ASSERT_TRUE(read.ok()) << read.error().text();
  EXPECT_EQ(read->keys.at(0).bytes()[1], 0x11);
  EXPECT_EQ(read->keys.at(0).bytes()[31], 0xFF);
}

// Whatever lets another user read it, or put another key there.
TEST(KeyFile, ThatOthersHaveAccessToIsRefusedWithTheCommandThatMendsIt) {
  const fakes::ScratchFolder folder;
  for (const mode_t mode : {0640u, 0604u, 0620u, 0602u, 0660u, 0644u, 0777u}) {
    const auto file = written(folder, std::string("flume-srd-key-1 n ") + kDigits + "\n", mode);
    const auto read = KeyFile::read(file);
    ASSERT_FALSE(read.ok()) << std::oct << mode;
    EXPECT_EQ(read.error().exit, Exit::kUsage);
    EXPECT_NE(read.error().advice.find("chmod 600 " + file.string()), std::string::npos) << read.error().text();
    ASSERT_EQ(std::system(read.error().advice.substr(0, read.error().advice.find(';')).c_str()), 0);
    EXPECT_TRUE(KeyFile::read(file).ok());
  }
}

TEST(KeyFile, OfAnotherUserIsRefusedWithTheCommandThatMendsIt) {
  if (::geteuid() != 0) GTEST_SKIP() << "only root can give a file away";
  const fakes::ScratchFolder folder;
  ASSERT_EQ(::chmod(folder.path().c_str(), 0755), 0);
  const auto file = written(folder, std::string("flume-srd-key-1 n ") + kDigits + "\n");
  ASSERT_EQ(::chown(file.c_str(), 1, 1), 0);
  EXPECT_TRUE(KeyFile::read(file).ok()) << "root examines a service's configuration";
  ASSERT_EQ(::seteuid(2), 0);
  const auto read = KeyFile::read(file);
  ASSERT_EQ(::seteuid(0), 0);
  ASSERT_FALSE(read.ok());
  EXPECT_NE(read.error().advice.find("chown bin: " + file.string()), std::string::npos) << read.error().text();
}

TEST(KeyFile, ThatIsNoneIsRefusedAndNotShown) {
  const fakes::ScratchFolder folder;
  const std::string digits = kDigits, line = "flume-srd-key-1 n " + digits;
  for (const std::string& text :
       {std::string(), std::string("# nothing\n"), digits + "\n", "flume-srd-key-2 n " + digits,
        line.substr(0, line.size() - 1), line + "0", line + " more", "flume-srd-key-1 n " + digits.substr(0, 63) + "g",
        "flume-srd-key-1  " + digits, line + "\nflume-srd-key-1 m " + digits, line + "\n" + line + "\n" + line,
        line + "\n" + std::string(2000, '#')}) {
    const auto read = KeyFile::read(written(folder, text));
    ASSERT_FALSE(read.ok()) << text;
    EXPECT_EQ(read.error().exit, Exit::kUsage);
    EXPECT_EQ(read.error().text().find("2233"), std::string::npos) << read.error().text();
  }
  for (const auto& path : {folder.path(), folder.path() / "absent.key", std::filesystem::path("/dev/null")})
    EXPECT_FALSE(KeyFile::read(path).ok()) << path;
}

}  // namespace
}  // namespace srd
