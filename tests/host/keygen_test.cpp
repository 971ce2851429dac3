// SPDX-License-Identifier: Apache-2.0
#include "host/keygen/keygen.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include "drivers/support/key_file.hpp"
#include "tests/fakes/scratch_folder.hpp"

namespace srd::host {
namespace {

TEST(Keygen, MakesAKeyForEachNodeThatItsOwnerAloneCanRead) {
  const fakes::ScratchFolder folder;
  const auto keys = folder.path() / "keys";
  const auto done = keygen({.nodes = {"a", "b"}, .folder = keys});
  ASSERT_TRUE(done.ok()) << done.error().text();
  struct stat info {};
  ASSERT_EQ(::stat(keys.c_str(), &info), 0);
  EXPECT_EQ(info.st_mode & 0777, 0700U);
  const auto a = KeyFile::read(keys / "a.key"), b = KeyFile::read(keys / "b.key");
  ASSERT_TRUE(a.ok() && b.ok());
  EXPECT_EQ(a->node, "a");
  EXPECT_FALSE(a->keys.front() == b->keys.front());
}

TEST(Keygen, ChangesAKeyAndEndsTheChange) {
  const fakes::ScratchFolder folder;
  const auto file = folder.path() / "a.key";
  KeygenOptions options{.nodes = {"a"}, .folder = folder.path()};
  ASSERT_TRUE(keygen(options).ok());
  const auto first = KeyFile::read(file).value().keys;
  EXPECT_EQ(keygen(options).error().exit, Exit::kUsage);
  EXPECT_TRUE(KeyFile::read(file).value().keys == first) << "a refusal changes nothing";
  options.change = true;
  ASSERT_TRUE(keygen(options).ok());
  const auto both = KeyFile::read(file).value().keys;
  ASSERT_EQ(both.size(), 2u);
  EXPECT_TRUE(both[1] == first[0]);
  EXPECT_FALSE(both[0] == first[0]);
  options.change = false;
  options.end_change = true;
  ASSERT_TRUE(keygen(options).ok());
  const auto last = KeyFile::read(file).value().keys;
  ASSERT_EQ(last.size(), 1u);
  EXPECT_TRUE(last[0] == both[0]);
}

TEST(Keygen, WritesNothingWhenOneNodeIsRefused) {
  const fakes::ScratchFolder folder;
  EXPECT_EQ(keygen({.nodes = {"good", "no good"}, .folder = folder.path()}).error().exit, Exit::kUsage);
  EXPECT_EQ(keygen({.nodes = {"good"}, .folder = folder.path(), .change = true}).error().exit, Exit::kUsage);
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

}  // namespace
}  // namespace srd::host
