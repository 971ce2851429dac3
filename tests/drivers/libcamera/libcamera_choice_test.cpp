// SPDX-License-Identifier: Apache-2.0
// What the libcamera driver makes of a camera's formats and controls, without a camera.
#include "drivers/camera/libcamera/libcamera_choice.hpp"

#include <gtest/gtest.h>

#include <libcamera/control_ids.h>

#include "drivers/camera/libcamera/libcamera_image.hpp"

namespace srd {
namespace {

using libcamera::ControlInfo;
using libcamera::ControlInfoMap;
using libcamera::ControlList;
using libcamera::ControlValue;
using libcamera::PixelFormat;
using libcamera::StreamRole;
namespace formats = libcamera::formats;

const std::vector<PixelFormat> kProcessed{formats::NV12, formats::YUV420, formats::RGB888, formats::YUYV};

TEST(LibcameraChoice, TakesTheRawStreamOfAMonochromeSensorFirst) {
  const auto tries = streams_to_try({formats::R10_CSI2P, formats::R10, formats::R8}, kProcessed);
  ASSERT_GE(tries.size(), 3U);
  EXPECT_EQ(tries[0].role, StreamRole::Raw);
  EXPECT_EQ(tries[0].format.format, formats::R8) << "read in place";
  EXPECT_EQ(tries[1].role, StreamRole::Raw);
  EXPECT_EQ(tries[1].format.format, formats::R10);
  EXPECT_EQ(tries[2].role, StreamRole::Viewfinder);
  EXPECT_EQ(tries[2].format.format, formats::YUV420);
  EXPECT_EQ(why_not_raw({formats::R10, formats::R8}, tries[0]), "");
}

TEST(LibcameraChoice, TakesTheYOfAColourSensorAndSaysWhy) {
  const std::vector<PixelFormat> raw{formats::SRGGB10, formats::SRGGB10_CSI2P};
  const auto tries = streams_to_try(raw, kProcessed);
  ASSERT_EQ(tries.size(), 4U);
  for (const StreamTry& wanted : tries) EXPECT_EQ(wanted.role, StreamRole::Viewfinder);
  EXPECT_EQ(tries[0].format.format, formats::YUV420);
  const std::string why = why_not_raw(raw, tries[0]);
  EXPECT_NE(why.find("colour sensor's mosaic (SRGGB10"), std::string::npos) << why;
}

TEST(LibcameraChoice, SaysWhyAMonochromeSensorIsNotReadRaw) {
  const StreamTry processed{StreamRole::Viewfinder, kLibcameraFormats[1]};
  const std::string size = why_not_raw({formats::R10}, processed), packed = why_not_raw({formats::R10_CSI2P}, processed);
  EXPECT_NE(size.find("raw stream (R10) has not this size"), std::string::npos) << size;
  EXPECT_NE(packed.find("packed (R10_CSI2P)"), std::string::npos) << packed;
}

// As the virtual media controller and USB cameras: the same formats for every role.
TEST(LibcameraChoice, PipelinesThatIgnoreRolesAreReadAsBefore) {
  const std::vector<PixelFormat> vimc{formats::RGB888, formats::BGR888};
  const auto tries = streams_to_try(vimc, vimc);
  ASSERT_FALSE(tries.empty());
  EXPECT_EQ(tries[0].role, StreamRole::Viewfinder);
  EXPECT_EQ(tries[0].format.format, formats::BGR888);
  EXPECT_EQ(why_not_raw(vimc, tries[0]), "");
}

ControlInfoMap known(ControlInfo sharpness, ControlInfo contrast, std::vector<std::int32_t> noise_modes) {
  std::vector<ControlValue> modes(noise_modes.begin(), noise_modes.end());
  return ControlInfoMap(ControlInfoMap::Map{{&libcamera::controls::Sharpness, sharpness},
                                            {&libcamera::controls::Contrast, contrast},
                                            {&libcamera::controls::Brightness, ControlInfo(-1.0F, 1.0F, 0.0F)},
                                            {&libcamera::controls::draft::NoiseReductionMode,
                                             ControlInfo(libcamera::Span<const ControlValue>(modes), modes.front())}},
                        libcamera::controls::controls);
}

TEST(LibcameraImage, SwitchesOffWhatChangesEdgesAndGreyLevels) {
  const ControlInfoMap map = known(ControlInfo(0.0F, 16.0F, 1.0F), ControlInfo(0.0F, 32.0F, 1.0F), {2, 0, 1});
  ControlList set(map);
  std::vector<std::string> notes;
  EXPECT_TRUE(neutral_image(map, {}, set, notes).empty());
  EXPECT_EQ(set.get(libcamera::controls::Sharpness), 0.0F);
  EXPECT_EQ(set.get(libcamera::controls::Contrast), 1.0F);
  EXPECT_EQ(set.get(libcamera::controls::Brightness), 0.0F);
  EXPECT_EQ(set.get(libcamera::controls::draft::NoiseReductionMode), 0);
}

TEST(LibcameraImage, NamesTheControlsThatTheCameraDoesNotLetGo) {
  const ControlInfoMap map = known(ControlInfo(0.5F, 16.0F, 1.0F), ControlInfo(1.2F, 32.0F, 1.5F), {1, 2});
  ControlList set(map);
  std::vector<std::string> notes;
  const auto concerns = neutral_image(map, {}, set, notes);
  ASSERT_EQ(concerns.size(), 3U);
  EXPECT_NE(concerns[0].find("sharpness is 0.5"), std::string::npos) << concerns[0];
  EXPECT_NE(concerns[1].find("noise reduction"), std::string::npos) << concerns[1];
  EXPECT_NE(concerns[2].find("contrast is 1.2, 1 is neutral"), std::string::npos) << concerns[2];
}

}  // namespace
}  // namespace srd
