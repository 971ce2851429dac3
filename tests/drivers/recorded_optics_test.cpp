// SPDX-License-Identifier: Apache-2.0
#include "drivers/recording/recorded_optics.hpp"

#include <gtest/gtest.h>

#include "tests/fakes/scratch_folder.hpp"

namespace srd {
namespace {

using fakes::ScratchFolder;

TEST(RecordedOptics, ComeBackAsWritten) {
  const ScratchFolder folder;
  for (const Plates& plates : {Plates{}, Plates{{12, 1.49}}, Plates{{1.0 / 3, 1.5}, {2, 1}, {3.25, 2.9999999}, {0.1, 1}}}) {
    RecordedOptics written;
    written.media.water = 1.3331 + 1e-9 / 3;
    set_plates(written.media, plates);
    if (!plates.empty()) written.model = dsp::SurfaceModel<double>{dsp::ModeList::standard(8).value(), 240, 440.5, -1.0 / 3, 7};
    ASSERT_TRUE(write_recorded_optics(folder.path(), written));
    const auto read = read_recorded_optics(folder.path());
    ASSERT_TRUE(read.ok()) << read.error().text();
    ASSERT_TRUE(read->has_value());
    const RecordedOptics& optics = **read;
    EXPECT_EQ(optics.media.water, written.media.water);
    EXPECT_TRUE(same_plates(plates_of(optics.media), plates));
    ASSERT_EQ(optics.model.has_value(), written.model.has_value());
    if (!optics.model) continue;
    EXPECT_EQ(optics.model->modes.size(), 8);
    EXPECT_EQ(optics.model->lx, 240);
    EXPECT_EQ(optics.model->ly, 440.5);
    EXPECT_EQ(optics.model->x0, -1.0 / 3);
    EXPECT_EQ(optics.model->y0, 7);
  }
}

TEST(RecordedOptics, AreNoneWhereTheRecordingHasNone) {
  const ScratchFolder folder;
  const auto read = read_recorded_optics(folder.path());
  ASSERT_TRUE(read.ok());
  EXPECT_FALSE(read->has_value());
}

TEST(RecordedOptics, WrongOnesAreRefusedWithTheirLine) {
  const ScratchFolder folder;
  const std::string water = "[water]\nrefractive_index = 1.333\n";
  for (const auto& [text, said] :
       {std::pair<std::string, const char*>{"", "refractive_index"},
        {"[water]\nrefractive_index = 2.5\n", "optics.toml:2"},
        {water + "[[water.plate]]\nindex = 1.5\n", "thickness_mm"},
        {water + "[[water.plate]]\nthickness_mm = 5.0\nindex = 0.9\n", "optics.toml:5"},
        {water + "depth = 3\n", "depth"},
        {water + "[surface]\nlx_mm = 1.0\nly_mm = 1.0\nx0_mm = 0.0\ny0_mm = 0.0\n", "modes"},
        {water + "[surface]\nmodes = [\"A00\", \"Q\"]\nlx_mm = 1.0\nly_mm = 1.0\nx0_mm = 0.0\ny0_mm = 0.0\n", "optics.toml:4"},
        {"not TOML", "optics.toml"}}) {
    folder.write(std::string(kOpticsName), text);
    const auto read = read_recorded_optics(folder.path());
    ASSERT_FALSE(read.ok()) << text;
    EXPECT_EQ(read.error().exit, Exit::kInput);
    EXPECT_NE(read.error().text().find(said), std::string::npos) << read.error().text();
  }
  std::string many = water;
  for (int i = 0; i < 5; ++i) many += "[[water.plate]]\nthickness_mm = 1.0\nindex = 1.5\n";
  folder.write(std::string(kOpticsName), many);
  EXPECT_FALSE(read_recorded_optics(folder.path()).ok());
}

}  // namespace
}  // namespace srd
