// SPDX-License-Identifier: Apache-2.0
#include "firmware/strobe/strobe_section.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "drivers/support/toml_reader.hpp"
#include "firmware/strobe/strobe.hpp"

namespace srd::firmware {
namespace {

// 50 Hz, 4 ms, global shutter, unless a test says otherwise.
StrobedCamera usual() {
  StrobedCamera camera;
  camera.exposure_us = 4000;
  camera.trigger_input = true;
  return camera;
}

Outcome<StrobeSection> read(const std::string& keys, const StrobedCamera& camera) {
  auto file = TomlFile::parse("[strobe]\n" + keys, "n.toml");
  if (!file) return file.error();
  const StrobeSection section = read_strobe(file->root().table("strobe"), camera);
  if (auto done = file->finish(); !done) return done.error();
  return section;
}

TEST(StrobeSection, IsOffUnlessAskedFor) {
  auto file = TomlFile::parse("", "n.toml");
  ASSERT_TRUE(file.ok());
  EXPECT_EQ(read_strobe(file->root().table("strobe"), {}).mode, StrobeMode::kOff);
  EXPECT_TRUE(file->finish().ok());
  EXPECT_TRUE(read("mode = \"off\"\n", {}).ok());  // nothing has to fit then
  EXPECT_TRUE(summary_of({}, true).empty());
}

TEST(StrobeSection, TakesWhatBoardsSay) {
  const auto strobe = read(
      "mode = \"follow\"\nchip = \"pinctrl-rp1\"\nline = 17\nactive_low = true\npulse_us = 300\ndelay_us = 12\n"
      "jitter_us = 150\nmax_pulse_us = 800\nmax_duty = 0.05\npattern = \"LLD\"\ndark_difference = 25\n",
      usual());
  ASSERT_TRUE(strobe.ok()) << strobe.error().text();
  EXPECT_EQ(strobe->line, "17");
  EXPECT_EQ(strobe->line_address().text(), "line 17 of pinctrl-rp1");
  EXPECT_TRUE(strobe->line_address().active_low);
  EXPECT_EQ(strobe->pattern.lit_count(), 2);
  EXPECT_EQ(strobe->dark_difference, 25);
  EXPECT_NE(summary_of(*strobe, true).find("follow"), std::string::npos);
  EXPECT_NE(summary_of(*strobe, false).find("not used"), std::string::npos);
  const auto trigger = read("mode = \"trigger\"\ntrigger_line = \"TRIGGER\"\n", usual());
  ASSERT_TRUE(trigger.ok()) << trigger.error().text();
  EXPECT_TRUE(trigger->line.empty());
}

TEST(StrobeSection, SaysWhatDoesNotFitWithItsNumbers) {
  struct Misfit {
    const char* keys;
    StrobedCamera camera;
    std::vector<const char*> said;
  };
  StrobedCamera rolling = usual(), unknown = usual(), fast = usual(), free = usual();
  rolling.shutter = Shutter::kRolling;
  rolling.readout_us = 3600;
  unknown.exposure_us.reset();
  fast.frame_rate_hz = 300;
  free.trigger_input = false;
  const std::vector<Misfit> cases{
      {"mode = \"on\"\n", usual(), {"n.toml:2", "strobe.mode", "follow", "on"}},
      {"mode = \"follow\"\n", usual(), {"n.toml:1", "strobe.line", "missing", "number or a name"}},
      {"mode = \"follow\"\nline = -3\n", usual(), {"n.toml:3", "strobe.line", "-3"}},
      {"mode = \"follow\"\nline = 17\nchip = \"\"\n", usual(), {"n.toml:4", "strobe.chip", "line 17"}},
      {"mode = \"follow\"\nline = 17\npattern = \"LXD\"\n", usual(), {"n.toml:4", "strobe.pattern", "LXD"}},
      {"mode = \"follow\"\nline = 17\npattern = \"DD\"\n", usual(), {"strobe.pattern", "at least one L"}},
      {"mode = \"follow\"\nline = 17\npulse_us = 2500\n",
       usual(),
       {"n.toml:4", "strobe.pulse_us", "max_pulse_us, 2000 us", "found 2500 us"}},
      {"mode = \"follow\"\nline = 17\npulse_us = 2000\nmax_duty = 0.05\n",
       usual(),
       {"n.toml:4", "max_duty, 0.0500", "at most 1000 us", "a duty of 0.1000"}},
      {"mode = \"follow\"\nline = 17\npulse_us = 1900\njitter_us = 2500\n",
       usual(),
       {"n.toml:4", "strobe.pulse_us + strobe.jitter_us = 1900 + 2500 = 4400 us", "found 4000 us"}},
      {"mode = \"follow\"\nline = 17\n",
       rolling,
       {"strobe.pulse_us", "3600 + 500 + 200 = 4300 us", "all rows of a rolling shutter", "found 4000 us"}},
      {"mode = \"follow\"\nline = 17\n", unknown, {"n.toml:2", "camera.exposure_us", "none"}},
      {"mode = \"follow\"\nline = 17\n", fast, {"n.toml:2", "frame's period, 3333 us", "found 4000 us"}},
      {"mode = \"trigger\"\ntrigger_line = 4\nline = 17\n", free, {"n.toml:2", "camera.trigger_input = true"}},
      {"mode = \"trigger\"\nline = 17\n", usual(), {"strobe.trigger_line", "missing"}},
      {"mode = \"trigger\"\nline = 17\ntrigger_line = 17\n", usual(), {"n.toml:4", "strobe.trigger_line", "another line"}},
      {"mode = \"trigger\"\ntrigger_line = 17\ntrigger_pulse_us = 11000\n", usual(), {"n.toml:4", "10000 us", "11000 us"}},
      {"mode = \"follow\"\nline = 17\npluse_us = 5\n", usual(), {"n.toml:4", "unknown key 'strobe.pluse_us'", "pulse_us"}},
  };
  for (const Misfit& wrong : cases) {
    const auto strobe = read(wrong.keys, wrong.camera);
    ASSERT_FALSE(strobe.ok()) << wrong.keys;
    EXPECT_EQ(strobe.error().exit, Exit::kUsage);
    for (const char* words : wrong.said)
      EXPECT_NE(strobe.error().text().find(words), std::string::npos) << strobe.error().text();
  }
}

TEST(StrobeSection, ADutyAtItsLimitIsAllowedAndPatternsCount) {
  EXPECT_TRUE(read("mode = \"follow\"\nline = 17\npulse_us = 1000\nmax_duty = 0.05\n", usual()).ok());
  EXPECT_FALSE(read("mode = \"follow\"\nline = 17\npulse_us = 1001\nmax_duty = 0.05\n", usual()).ok());
  EXPECT_TRUE(read("mode = \"follow\"\nline = 17\npulse_us = 2000\nmax_duty = 0.05\npattern = \"LD\"\n", usual()).ok());
}

TEST(StrobeSection, PlacesLightWhereAllRowsIntegrate) {
  StrobeSection section;
  section.mode = StrobeMode::kTrigger;
  FrameTiming frame;
  frame.shutter = Shutter::kRolling;
  frame.exposure_ns = 10'000'000;
  frame.readout_ns = 6'000'000;
  frame.row_fraction = FrameTiming::kWholeHeight / 2;
  // The middle row's middle is 3 + 5 ms after the first row begins; all integrate from 6 to 10 ms.
  const StrobeTiming timing = strobe_timing(section, frame, 29.97);
  EXPECT_EQ(timing.window_begin_ns, -2'000'000);
  EXPECT_EQ(timing.window_end_ns, 2'000'000);
  EXPECT_EQ(timing.stamp_after_trigger_ns, 8'000'000);
  EXPECT_EQ(timing.trigger_rate_mhz, 29'970);
  EXPECT_EQ(timing.max_duty_ppm, 100'000);
}

}  // namespace
}  // namespace srd::firmware
