// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>

#include "drivers/strobe/gpiod_line.hpp"
#include "tests/fakes/recording_line.hpp"
#include "tests/fakes/scratch_folder.hpp"

namespace srd {
namespace {

TEST(StrobeLine, TheRecordingOneKeepsEdgesWithTheirTimes) {
  std::int64_t now = 5;
  fakes::RecordingLine line([&] { return now; });
  line.set(false);
  EXPECT_TRUE(line.edges().empty());
  line.set(true);
  now = 9;
  line.set(true);
  line.set(false);
  ASSERT_EQ(line.pulses().size(), 1u);
  EXPECT_EQ(line.pulses()[0].on_ns, 5);
  EXPECT_EQ(line.pulses()[0].off_ns, 9);
  EXPECT_EQ(line.calls(), 4u);
  EXPECT_FALSE(line.on());
}

// What is said without the device; lines themselves are tried on the emulated board.
TEST(GpiodLine, SaysWhichChipsThereAreWhenTheWantedOneIsNot) {
  if (gpiod_version().empty()) GTEST_SKIP() << "built without libgpiod";
  for (const std::string chip : {"/dev/gpiochip-of-nobody", "chip-of-nobody"}) {
    const auto line = open_gpiod_line({chip, "17"}, "test");
    ASSERT_FALSE(line.ok());
    EXPECT_EQ(line.error().exit, Exit::kDevice);
    EXPECT_EQ(line.error().where, chip);
    EXPECT_NE(line.error().found.find("gpiochip"), std::string::npos) << line.error().text();
    EXPECT_NE(line.error().advice.find("strobe.chip"), std::string::npos);
  }
}

TEST(GpiodLine, AFileThatIsNoChipIsNamed) {
  if (gpiod_version().empty()) GTEST_SKIP() << "built without libgpiod";
  const auto line = open_gpiod_line({"/dev/null", "17"}, "test");
  ASSERT_FALSE(line.ok());
  EXPECT_EQ(line.error().exit, Exit::kDevice);
  EXPECT_NE(line.error().text().find("/dev/null"), std::string::npos);
  EXPECT_NE(line.error().what.find("no GPIO chip"), std::string::npos);
}

TEST(GpiodLine, ANameThatNoChipHasIsNamed) {
  if (gpiod_version().empty()) GTEST_SKIP() << "built without libgpiod";
  const auto line = open_gpiod_line({"", "no such line anywhere"}, "test");
  ASSERT_FALSE(line.ok());
  EXPECT_NE(line.error().what.find("no such line anywhere"), std::string::npos);
}

// A chip that may not be opened tells neither its label nor its lines: it may be the one that is meant.
TEST(GpiodLine, AChipThatIsNotPermittedIsNoMissingOne) {
  if (gpiod_version().empty()) GTEST_SKIP() << "built without libgpiod";
  const fakes::ScratchFolder devices;
  const std::string chip = devices.write("gpiochip3", "").string();
  ASSERT_EQ(::chmod(chip.c_str(), 0), 0);
  ASSERT_EQ(::chmod(devices.path().c_str(), 0755), 0);
  std::fflush(stdout);
  const pid_t child = ::fork();
  if (child == 0) {  // not as root, who may open anything
    if (::geteuid() == 0 && ::setresuid(65534, 65534, 65534) != 0) ::_exit(2);
    int wrong = 0;
    for (const LineAddress& address : {LineAddress{"pinctrl-rp1", "17"}, {"gpiochip3", "17"}, {chip, "17"}, {"", "GPIO17"}}) {
      const auto line = open_gpiod_line(address, "test", devices.path());
      if (!line.ok() && line.error().what.starts_with("no permission") && line.error().where == chip &&
          line.error().found.find("group") != std::string::npos)
        continue;
      wrong = 1;
      std::printf("%s: %s", address.text().c_str(), line.ok() ? "opened" : line.error().text().c_str());
    }
    std::fflush(stdout);
    ::_exit(wrong);
  }
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  EXPECT_EQ(status, 0);
}

TEST(GpiodLine, ABuildWithoutTheLibraryRefusesAndSaysSo) {
  if (!gpiod_version().empty()) {
    EXPECT_TRUE(gpiod_version().starts_with("libgpiod ")) << gpiod_version();
    return;
  }
  const auto line = open_gpiod_line({"/dev/gpiochip0", "17"}, "test");
  ASSERT_FALSE(line.ok());
  EXPECT_EQ(line.error().exit, Exit::kUsage);
  EXPECT_NE(line.error().text().find("libgpiod"), std::string::npos);
}

}  // namespace
}  // namespace srd
