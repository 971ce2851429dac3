// SPDX-License-Identifier: Apache-2.0
#include "firmware/transmit/spill.hpp"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/mount.h>
#include <sys/resource.h>
#include <unistd.h>

#include <chrono>
#include <fstream>
#include <random>
#include <thread>

#include "proto/node_codec.hpp"
#include "tests/fakes/scratch_folder.hpp"

namespace srd::firmware {
namespace {

constexpr std::int64_t kMs = 1'000'000;

proto::BootId boot_of(std::uint64_t boot) { return {*proto::NodeId::make("cam-1"), boot}; }

std::vector<std::uint8_t> encoded(const proto::BootId& from, std::uint64_t sequence) {
  proto::CoefficientFrame frame;
  frame.stamp.sensor_time_ns = static_cast<std::int64_t>(sequence * 1000);
  frame.model.modes = dsp::ModeList::standard(5).value();
  frame.model.lx = frame.model.ly = 200;
  std::vector<std::uint8_t> bytes(proto::kMaxEncoded);
  bytes.resize(*proto::encode(from, sequence, frame, bytes));
  return bytes;
}

SpillOptions options_in(const std::filesystem::path& folder, std::size_t frames = 500) {
  return {.folder = folder, .frames = frames, .frame_bytes = 200, .sync_interval = 100 * kMs};
}

std::filesystem::path only_file(const std::filesystem::path& folder) {
  return std::filesystem::directory_iterator(folder)->path();
}

void expect_frames(const SpilledFrames& spilled, std::uint64_t begin, std::uint64_t end) {
  ASSERT_EQ(spilled.frames.size(), end - begin);
  for (std::uint64_t s = begin; s < end; ++s) {
    EXPECT_EQ(spilled.frames[s - begin].sequence, s);
    EXPECT_EQ(spilled.frames[s - begin].encoded, encoded(spilled.of, s));
  }
}

TEST(SpillFile, GivesBackWhatTheHostDidNotTake) {
  const fakes::ScratchFolder folder;
  for (const std::uint64_t generation : {2u, 1u}) {
    auto spill = SpillFile::create(options_in(folder.path()), boot_of(generation), generation);
    ASSERT_TRUE(spill.ok()) << spill.error().text();
    // Round the cells twice; the host is up to 300 behind.
    for (std::uint64_t s = 0; s < 1000; ++s) {
      if (s >= 300) (*spill)->release(s - 299, {});
      (*spill)->put(s, encoded(boot_of(generation), s));
    }
    EXPECT_EQ((*spill)->problem(), "");
    EXPECT_EQ((*spill)->counts().written, 1000u);
    EXPECT_TRUE(SpillFile::read_all(folder.path()).size() == (generation == 2 ? 0u : 1u)) << "a living process's is no other's";
  }
  const auto all = SpillFile::read_all(folder.path());
  ASSERT_EQ(all.size(), 2u);
  for (std::uint64_t i = 1; i <= 2; ++i) {
    EXPECT_EQ(all[i - 1].of, boot_of(i));
    EXPECT_EQ(all[i - 1].generation, i);
    EXPECT_EQ(all[i - 1].oldest, 700u);
    expect_frames(all[i - 1], 700, 1000);
  }
}

// While the host answers the same few cells serve: the file's other pages are never touched, and nothing is synced.
TEST(SpillFile, WearsNoDiskWhileTheHostAnswers) {
  const fakes::ScratchFolder folder;
  {
    auto spill = SpillFile::create(options_in(folder.path(), 5000), boot_of(1), 1);
    ASSERT_TRUE(spill.ok());
    for (std::uint64_t s = 0; s < 20000; ++s) {
      if (s >= 10) (*spill)->release(s - 9, {});
      (*spill)->put(s, encoded(boot_of(1), s));
      (*spill)->tick(static_cast<std::int64_t>(s) * 5 * kMs);
    }
    EXPECT_EQ((*spill)->counts().syncs, 0u);
  }
  const std::string bytes = fakes::bytes_of(only_file(folder.path()));
  EXPECT_GT(bytes.size(), 1'000'000u);
  EXPECT_LT(bytes.find_last_not_of('\0'), 3 * 4096u);
}

// With the host away: at most a sync a second, and nothing is left for it.
TEST(SpillFile, SyncsInGroupsWhileTheHostIsAway) {
  const fakes::ScratchFolder folder;
  auto spill = SpillFile::create(options_in(folder.path(), 5000), boot_of(1), 1);
  ASSERT_TRUE(spill.ok());
  const auto begin = std::chrono::steady_clock::now();
  const auto ns = [&] { return std::chrono::nanoseconds(std::chrono::steady_clock::now() - begin).count(); };
  std::uint64_t s = 0;
  for (; ns() < 500 * kMs; ++s) {
    (*spill)->put(s, encoded(boot_of(1), s));
    (*spill)->tick(ns());
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  for (int i = 0; i < 200 && (*spill)->counts().syncs == 0; ++i) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  EXPECT_GE((*spill)->counts().syncs, 1u);
  EXPECT_LE((*spill)->counts().syncs, 5u);
  // Cells of 256 bytes and nothing else.
  EXPECT_LT((*spill)->counts().written_bytes, s * 256 + 200);
}

TEST(SpillFile, CutOrDamagedAnywhereGivesWholeFramesOnly) {
  const fakes::ScratchFolder folder;
  {
    auto spill = SpillFile::create(options_in(folder.path(), 64), boot_of(7), 1);
    ASSERT_TRUE(spill.ok());
    for (std::uint64_t s = 0; s < 60; ++s) (*spill)->put(s, encoded(boot_of(7), s));
    (*spill)->release(20, {});
  }
  const std::string good = fakes::bytes_of(only_file(folder.path()));
  std::mt19937_64 random(1);
  for (int i = 0; i < 1000; ++i) {
    std::string bad = good;
    if (i % 2 == 0)
      bad.resize(random() % bad.size());
    else
      for (auto hits = 1 + random() % 20; hits > 0; --hits) bad[random() % bad.size()] = static_cast<char>(random());
    const auto file = folder.write("bad/x.spill", bad);
    const auto spilled = SpillFile::read(file);
    ASSERT_TRUE(spilled.ok());
    for (const auto& frame : spilled->frames) ASSERT_EQ(frame.encoded, encoded(boot_of(7), frame.sequence));
    ASSERT_LE(spilled->frames.size(), 60u);
    if (i % 2 == 1) {
      ASSERT_GE(spilled->frames.size() + 20, 40u);
    }
  }
  // Without its head the frames are there all the same.
  std::string headless = good;
  headless[9] = static_cast<char>(headless[9] ^ 1);
  const auto spilled = SpillFile::read(folder.write("bad/x.spill", headless));
  ASSERT_TRUE(spilled.ok());
  EXPECT_EQ(spilled->of, boot_of(7));
  expect_frames(*spilled, 0, 60);
}

TEST(SpillFile, OfADiskWithoutRoomIsRefusedAndLeavesNothing) {
  const fakes::ScratchFolder folder;
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  const auto handler = ::signal(SIGXFSZ, SIG_IGN);
  const rlimit small{100'000, before.rlim_max};
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &small), 0);
  const auto spill = SpillFile::create(options_in(folder.path(), 5000), boot_of(1), 1);
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &before), 0);
  ::signal(SIGXFSZ, handler);
  ASSERT_FALSE(spill.ok());
  EXPECT_EQ(spill.error().exit, Exit::kInput);
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

// Its room was taken at the start.
TEST(SpillFile, GoesOnWhenTheDiskHasFilledUp) {
  const fakes::ScratchFolder folder;
  if (::mount("tmpfs", folder.path().c_str(), "tmpfs", 0, "size=1m") != 0) GTEST_SKIP() << "only root can mount a small disk";
  {
    auto spill = SpillFile::create(options_in(folder.path(), 1000), boot_of(1), 1);
    ASSERT_TRUE(spill.ok()) << spill.error().text();
    std::ofstream(folder.path() / "other") << std::string(4 << 20, 'x');
    EXPECT_EQ(std::filesystem::space(folder.path()).available, 0u);
    for (std::uint64_t s = 0; s < 1000; ++s) (*spill)->put(s, encoded(boot_of(1), s));
    EXPECT_EQ((*spill)->problem(), "");
  }
  const auto all = SpillFile::read_all(folder.path());
  ASSERT_EQ(all.size(), 1u);
  expect_frames(all.front(), 0, 1000);
  ASSERT_EQ(::umount(folder.path().c_str()), 0);
}

}  // namespace
}  // namespace srd::firmware
