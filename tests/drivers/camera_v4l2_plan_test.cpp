// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cerrno>

#include "drivers/camera/v4l2/v4l2_plan.hpp"
#include "tests/fakes/scripted_v4l2_port.hpp"

namespace srd {
namespace {

using fakes::ScriptedControl;
using fakes::ScriptedV4l2Device;
using fakes::ScriptedV4l2Port;

V4l2Ask ask_for(int width, int height) {
  V4l2Ask ask;
  ask.path = "/dev/video9";
  ask.width = width;
  ask.height = height;
  return ask;
}

V4l2Plan planned(ScriptedV4l2Device& device, const V4l2Ask& ask) {
  ScriptedV4l2Port port(device);
  auto plan = plan_capture(port, ask);
  EXPECT_TRUE(plan.ok()) << plan.error().text();
  return plan ? *plan : V4l2Plan{};
}

void expect_refused(ScriptedV4l2Device& device, const V4l2Ask& ask, const std::vector<std::string>& words) {
  ScriptedV4l2Port port(device);
  const auto plan = plan_capture(port, ask);
  ASSERT_FALSE(plan.ok());
  EXPECT_EQ(plan.error().exit, Exit::kDevice);
  for (const std::string& word : words)
    EXPECT_NE(plan.error().text().find(word), std::string::npos) << "no \"" << word << "\" in: " << plan.error().text();
}

bool noted(const V4l2Plan& plan, const std::string& words) {
  for (const std::string& note : plan.notes)
    if (note.find(words) != std::string::npos) return true;
  return false;
}

std::int32_t set_to(const V4l2Plan& plan, std::uint32_t id) {
  for (int i = 0; i < plan.settings.control_count; ++i)
    if (plan.settings.controls[static_cast<std::size_t>(i)].id == id)
      return plan.settings.controls[static_cast<std::size_t>(i)].value;
  return -1;
}

TEST(V4l2Plan, AutoTakesTheFirstFormatOfItsOrderInTheSizeWanted) {
  ScriptedV4l2Device device;
  device.formats = {{V4L2_PIX_FMT_H264}, {V4L2_PIX_FMT_MJPEG},         {V4L2_PIX_FMT_NV12},
                    {V4L2_PIX_FMT_YUYV}, {V4L2_PIX_FMT_Y12, 640, 480}, {V4L2_PIX_FMT_Y10, 64, 48}};
  EXPECT_EQ(planned(device, ask_for(64, 48)).format.name, "Y10");
  EXPECT_EQ(planned(device, ask_for(640, 480)).format.name, "Y12");
  V4l2Ask nv12 = ask_for(64, 48);
  nv12.format = "NV12";
  EXPECT_EQ(planned(device, nv12).format.code, static_cast<std::uint32_t>(V4L2_PIX_FMT_NV12));
}

TEST(V4l2Plan, AutoTakesAnotherFormatWhereThePreferredOneIsTooSlow) {
  ScriptedV4l2Device device;
  device.formats = {{V4L2_PIX_FMT_YUYV, 1280, 720, {5, 10}}, {V4L2_PIX_FMT_MJPEG, 1280, 720, {30}}};
  V4l2Ask ask = ask_for(1280, 720);
  ask.rate_hz = 10;
  EXPECT_EQ(planned(device, ask).format.name, "YUYV");
  ask.rate_hz = 30;
  const V4l2Plan fast = planned(device, ask);
  EXPECT_EQ(fast.format.name, "MJPG");
  EXPECT_DOUBLE_EQ(fast.rate_hz, 30);
  // None is so fast: the preferred one again.
  ask.rate_hz = 60;
  EXPECT_EQ(planned(device, ask).format.name, "YUYV");
}

TEST(V4l2Plan, AMosaicHasTwiceTheSizeThatIsAsked) {
  ScriptedV4l2Device device;
  device.formats = {{V4L2_PIX_FMT_SRGGB10, 1280, 960}, {V4L2_PIX_FMT_SRGGB8, 640, 480}};
  const V4l2Plan plan = planned(device, ask_for(640, 480));
  EXPECT_EQ(plan.format.name, "SRGGB10");
  EXPECT_EQ(plan.settings.width, 1280);
  EXPECT_EQ(planned(device, ask_for(320, 240)).format.name, "SRGGB8");
  expect_refused(device, ask_for(1280, 960), {"size", "SRGGB10 (colour, halved) 640x480", "SRGGB8 (colour, halved) 320x240"});
}

TEST(V4l2Plan, SaysWhatTheDeviceOffersInsteadOfAFormatSizeOrRate) {
  ScriptedV4l2Device device;
  device.formats = {{V4L2_PIX_FMT_YUYV, 640, 480, {15, 30}}, {V4L2_PIX_FMT_YUYV, 320, 240, {30, 60}}, {V4L2_PIX_FMT_H264}};
  V4l2Ask grey = ask_for(640, 480);
  grey.format = "GREY";
  expect_refused(device, grey,
                 {"/dev/video9", "pixel format", "GREY", "YUYV 640x480 (15, 30 Hz), 320x240 (30, 60 Hz)", "not usable: H264",
                  "camera.format"});
  expect_refused(device, ask_for(1280, 720), {"size", "1280x720", "YUYV 640x480", "320x240"});
  V4l2Ask fast = ask_for(640, 480);
  fast.rate_hz = 60;
  fast.rate_required = true;
  expect_refused(device, fast,
                 {"frame rate", "60 Hz at 640x480 YUYV", "15, 30 Hz", "it would run at 30 Hz", "camera.frame_rate_hz"});
  fast.rate_required = false;
  EXPECT_TRUE(noted(planned(device, fast), "frame rate 30 Hz, the device's own"));
}

TEST(V4l2Plan, RefusesWhatIsNoCamera) {
  ScriptedV4l2Device device;
  device.capabilities = V4L2_CAP_VIDEO_OUTPUT | V4L2_CAP_STREAMING;
  expect_refused(device, ask_for(64, 48), {"not a camera", "a video output", "--list-cameras"});
  device.capabilities = V4L2_CAP_META_CAPTURE | V4L2_CAP_STREAMING;
  expect_refused(device, ask_for(64, 48), {"a metadata node"});
  device.capabilities = V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_READWRITE;
  expect_refused(device, ask_for(64, 48), {"cannot stream into buffers"});
  device.capabilities = V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_STREAMING;
  device.field = V4L2_FIELD_INTERLACED;
  expect_refused(device, ask_for(64, 48), {"interlaced", "progressive"});
  device.errors[VIDIOC_QUERYCAP] = ENOTTY;
  expect_refused(device, ask_for(64, 48), {"not a video device", "/dev/video9"});
}

TEST(V4l2Plan, SaysWhoHoldsTheDeviceAndWhichGroupMayOpenIt) {
  ScriptedV4l2Device device;
  device.open_error = EACCES;
  expect_refused(device, ask_for(64, 48), {"no permission", "group 'video'", "usermod"});
  device.open_error = 0;
  device.errors[VIDIOC_S_FMT] = EBUSY;
  expect_refused(device, ask_for(64, 48), {"in use by another program", "fuser"});
  V4l2Ask other = ask_for(64, 48);
  other.path = "/dev/video77";
  expect_refused(device, other, {"no such camera", "/dev/video77", "--list-cameras"});
}

TEST(V4l2Plan, SwitchesAutomaticsOffAndSetsExposureInUnitsOf100us) {
  ScriptedV4l2Device device;
  device.controls[V4L2_CID_EXPOSURE_AUTO] = {0, 3, 1, 3, {V4L2_EXPOSURE_MANUAL, V4L2_EXPOSURE_APERTURE_PRIORITY}};
  device.controls[V4L2_CID_EXPOSURE_AUTO_PRIORITY] = {0, 1, 1, 1};
  device.controls[V4L2_CID_EXPOSURE_ABSOLUTE] = {5, 2500, 1, 150};
  device.controls[V4L2_CID_AUTOGAIN] = {0, 1, 1, 1};
  device.controls[V4L2_CID_GAIN] = {0, 255, 5, 64};
  V4l2Ask ask = ask_for(64, 48);
  ask.exposure_us = 2000;
  ask.gain = 20;
  const V4l2Plan plan = planned(device, ask);
  EXPECT_EQ(set_to(plan, V4L2_CID_EXPOSURE_AUTO), V4L2_EXPOSURE_MANUAL);
  EXPECT_EQ(set_to(plan, V4L2_CID_EXPOSURE_AUTO_PRIORITY), 0);
  EXPECT_EQ(set_to(plan, V4L2_CID_EXPOSURE_ABSOLUTE), 20);
  EXPECT_EQ(set_to(plan, V4L2_CID_AUTOGAIN), 0);
  EXPECT_EQ(set_to(plan, V4L2_CID_GAIN), 20);
  EXPECT_EQ(plan.exposure_ns, 2'000'000);
  EXPECT_TRUE(plan.notes.empty());
  EXPECT_EQ(plan.settings.controls[0].id, static_cast<std::uint32_t>(V4L2_CID_EXPOSURE_AUTO)) << "before the value";
}

TEST(V4l2Plan, ReportsClampedValues) {
  ScriptedV4l2Device device;
  device.controls[V4L2_CID_EXPOSURE_ABSOLUTE] = {5, 100, 1, 50};
  device.controls[V4L2_CID_ANALOGUE_GAIN] = {16, 64, 8, 16};
  device.controls[V4L2_CID_GAIN] = {0, 255, 1, 0};
  V4l2Ask ask = ask_for(64, 48);
  ask.exposure_us = 40'000;
  ask.gain = 1.5;
  const V4l2Plan plan = planned(device, ask);
  EXPECT_EQ(set_to(plan, V4L2_CID_EXPOSURE_ABSOLUTE), 100);
  EXPECT_EQ(plan.exposure_ns, 10'000'000);
  EXPECT_TRUE(noted(plan, "exposure 10000 us instead of 40000 us"));
  EXPECT_EQ(set_to(plan, V4L2_CID_ANALOGUE_GAIN), 16);
  EXPECT_EQ(set_to(plan, V4L2_CID_GAIN), -1) << "analogue gain goes before";
  EXPECT_TRUE(noted(plan, "gain 16 instead of 1.5"));
}

TEST(V4l2Plan, SaysWhichControlsAreMissing) {
  ScriptedV4l2Device device;
  V4l2Ask ask = ask_for(64, 48);
  ask.exposure_us = 2000;
  ask.gain = 1;
  const V4l2Plan without = planned(device, ask);
  EXPECT_TRUE(noted(without, "exposure cannot be set: the device has no such control"));
  EXPECT_TRUE(noted(without, "gain cannot be set"));
  EXPECT_EQ(without.exposure_ns, 2'000'000);
  device.controls[V4L2_CID_EXPOSURE] = {4, 1100, 1, 500};
  const V4l2Plan lines = planned(device, ask);
  EXPECT_TRUE(noted(lines, "the device takes lines (4 to 1100, now 500)"));
  EXPECT_EQ(set_to(lines, V4L2_CID_EXPOSURE), -1);
}

// 1456 + 304 pixels at 100 million a second: a line of 17.6 us.
ScriptedV4l2Device line_sensor() {
  ScriptedV4l2Device device;
  device.formats = {{V4L2_PIX_FMT_Y10, 1456, 1088}};
  device.pixel_rate = 100'000'000;
  device.controls[V4L2_CID_HBLANK] = {304, 304, 1, 304, {}, V4L2_CTRL_FLAG_READ_ONLY};
  device.controls[V4L2_CID_EXPOSURE] = {4, 1100, 1, 500};
  return device;
}

TEST(V4l2Plan, ConvertsAnExposureToTheLinesOfTheSensor) {
  ScriptedV4l2Device device = line_sensor();
  V4l2Ask ask = ask_for(1456, 1088);
  ask.exposure_us = 1760;
  const V4l2Plan exact = planned(device, ask);
  EXPECT_EQ(set_to(exact, V4L2_CID_EXPOSURE), 100);
  EXPECT_EQ(device.controls[V4L2_CID_EXPOSURE].value, 100);
  EXPECT_EQ(exact.exposure_ns, 1'760'000);
  EXPECT_FALSE(noted(exact, "exposure"));
  ask.exposure_us = 2000;  // 113.6 lines
  const V4l2Plan nearest = planned(device, ask);
  EXPECT_EQ(set_to(nearest, V4L2_CID_EXPOSURE), 114);
  EXPECT_EQ(nearest.exposure_ns, 2'006'400);
  EXPECT_TRUE(noted(nearest,
                    "exposure 2006.4 us (114 lines) instead of 2000 us: the device takes 70.4 to 19360 us, in lines of "
                    "17.6 us"));
  ask.exposure_us = 30'000;
  EXPECT_EQ(planned(device, ask).exposure_ns, 19'360'000) << "the longest that it takes";
}

TEST(V4l2Plan, ReadsAnExposureInLinesThatIsLeftAsItIs) {
  ScriptedV4l2Device device = line_sensor();
  const V4l2Plan plan = planned(device, ask_for(1456, 1088));
  EXPECT_EQ(plan.exposure_ns, 8'800'000) << "500 lines";
  EXPECT_TRUE(noted(plan, "exposure left at 8800 us"));
}

TEST(V4l2Plan, CountsALineOverTheSensorsCropWhereTheImageIsBinned) {
  ScriptedV4l2Device device = line_sensor();
  device.formats = {{V4L2_PIX_FMT_Y10, 728, 544}};
  device.crop_width = 1456;
  V4l2Ask ask = ask_for(728, 544);
  ask.exposure_us = 1760;
  EXPECT_EQ(set_to(planned(device, ask), V4L2_CID_EXPOSURE), 100);
}

TEST(V4l2Plan, SaysThatAnExposureInLinesNeedsTheLineTime) {
  for (const bool rate : {false, true}) {
    ScriptedV4l2Device device = line_sensor();
    if (rate)
      device.controls.erase(V4L2_CID_HBLANK);
    else
      device.pixel_rate = 0;
    V4l2Ask ask = ask_for(1456, 1088);
    ask.exposure_us = 2000;
    const V4l2Plan plan = planned(device, ask);
    EXPECT_EQ(set_to(plan, V4L2_CID_EXPOSURE), -1);
    EXPECT_EQ(device.controls[V4L2_CID_EXPOSURE].value, 500);
    EXPECT_TRUE(noted(plan, "does not tell how long a line is")) << "pixel rate told: " << rate;
  }
}

TEST(V4l2Plan, LeavesOutControlsThatTheDeviceRefuses) {
  ScriptedV4l2Device device;
  device.controls[V4L2_CID_EXPOSURE_ABSOLUTE] = {5, 2500, 1, 150};
  device.errors[VIDIOC_S_CTRL] = EACCES;
  V4l2Ask ask = ask_for(64, 48);
  ask.exposure_us = 2000;
  const V4l2Plan plan = planned(device, ask);
  EXPECT_EQ(plan.settings.control_count, 0);
  EXPECT_TRUE(noted(plan, "exposure cannot be set: Permission denied"));
}

bool has_concern(const V4l2Plan& plan, const std::string& words) {
  for (const std::string& concern : plan.concerns)
    if (concern.find(words) != std::string::npos) return true;
  return false;
}

TEST(V4l2Plan, SwitchesOffWhatChangesTheImage) {
  ScriptedV4l2Device device;
  device.controls[V4L2_CID_SHARPNESS] = {1, 7, 1, 3};
  device.controls[V4L2_CID_AUTO_WHITE_BALANCE] = {0, 1, 1, 1};
  device.controls[V4L2_CID_BACKLIGHT_COMPENSATION] = {0, 2, 1, 1};
  device.controls[V4L2_CID_POWER_LINE_FREQUENCY] = {0, 2, 1, 1};
  device.controls[V4L2_CID_WIDE_DYNAMIC_RANGE] = {0, 1, 1, 1};
  device.controls[V4L2_CID_CONTRAST] = {0, 64, 1, 50};
  device.controls[V4L2_CID_CONTRAST].standard = 32;
  device.controls[V4L2_CID_GAMMA] = {72, 500, 1, 220};
  device.controls[V4L2_CID_FOCUS_AUTO] = {0, 1, 1, 1};
  device.controls[V4L2_CID_FOCUS_ABSOLUTE] = {0, 250, 5, 35};
  V4l2Ask ask = ask_for(64, 48);
  const V4l2Plan still = planned(device, ask);
  EXPECT_EQ(device.controls[V4L2_CID_SHARPNESS].value, 1) << "the least, whatever its number";
  for (const std::uint32_t id : {V4L2_CID_AUTO_WHITE_BALANCE, V4L2_CID_BACKLIGHT_COMPENSATION, V4L2_CID_POWER_LINE_FREQUENCY,
                                 V4L2_CID_WIDE_DYNAMIC_RANGE, V4L2_CID_FOCUS_AUTO})
    EXPECT_EQ(device.controls[id].value, 0) << id;
  EXPECT_EQ(device.controls[V4L2_CID_CONTRAST].value, 32);
  EXPECT_EQ(device.controls[V4L2_CID_GAMMA].value, 100);
  EXPECT_EQ(device.controls[V4L2_CID_FOCUS_ABSOLUTE].value, 35) << "the lens stays";
  EXPECT_TRUE(noted(still, "the lens stays where it is, at focus 35"));
  EXPECT_TRUE(still.concerns.empty());
  ask.focus = 101;
  ask.sharpness = 4;
  const V4l2Plan asked = planned(device, ask);
  EXPECT_EQ(device.controls[V4L2_CID_FOCUS_ABSOLUTE].value, 100);
  EXPECT_TRUE(noted(asked, "focus 100 instead of 101"));
  EXPECT_EQ(device.controls[V4L2_CID_SHARPNESS].value, 4);
  EXPECT_TRUE(has_concern(asked, "sharpness is 4, its least is 1"));
  // A device that comes back gets them again.
  EXPECT_EQ(set_to(asked, V4L2_CID_SHARPNESS), 4);
  EXPECT_EQ(set_to(asked, V4L2_CID_FOCUS_AUTO), 0);
}

TEST(V4l2Plan, NamesTheControlThatGoesOnChangingTheImage) {
  ScriptedV4l2Device stubborn;
  stubborn.controls[V4L2_CID_SHARPNESS] = {0, 7, 1, 3};
  stubborn.controls[V4L2_CID_SHARPNESS].stubborn = true;
  EXPECT_TRUE(has_concern(planned(stubborn, ask_for(64, 48)), "sharpness is 3, its least is 0"));
  ScriptedV4l2Device fixed;
  fixed.controls[V4L2_CID_SHARPNESS] = {0, 7, 1, 2, {}, V4L2_CTRL_FLAG_READ_ONLY};
  EXPECT_TRUE(has_concern(planned(fixed, ask_for(64, 48)), "sharpness is 2, its least is 0"));
  ScriptedV4l2Device refusing;
  refusing.controls[V4L2_CID_POWER_LINE_FREQUENCY] = {0, 2, 1, 1};
  refusing.errors[VIDIOC_S_CTRL] = EIO;
  const V4l2Plan refused = planned(refusing, ask_for(64, 48));
  EXPECT_TRUE(has_concern(refused, "the power-line filter cannot be set: Input/output error"));
  EXPECT_EQ(refused.settings.control_count, 0);
  ScriptedV4l2Device none;
  V4l2Ask ask = ask_for(64, 48);
  ask.focus = 3;
  const V4l2Plan without = planned(none, ask);
  EXPECT_TRUE(noted(without, "focus cannot be set: the device has no such control"));
  EXPECT_TRUE(without.concerns.empty());
}

TEST(V4l2Plan, LeavesExposureAloneWhenNoneIsAsked) {
  ScriptedV4l2Device device;
  device.controls[V4L2_CID_EXPOSURE_ABSOLUTE] = {5, 2500, 1, 150};
  const V4l2Plan fixed = planned(device, ask_for(64, 48));
  EXPECT_EQ(fixed.settings.control_count, 0);
  EXPECT_EQ(fixed.exposure_ns, 15'000'000);
  device.controls[V4L2_CID_EXPOSURE_AUTO] = {0, 3, 1, V4L2_EXPOSURE_APERTURE_PRIORITY, {0, 3}};
  const V4l2Plan automatic = planned(device, ask_for(64, 48));
  EXPECT_EQ(automatic.exposure_ns, 0);
  EXPECT_TRUE(noted(automatic, "left automatic"));
}

TEST(V4l2Plan, ADeviceThatCannotSayItsRateIsTakenAtTheWord) {
  ScriptedV4l2Device device;
  device.errors[VIDIOC_G_PARM] = ENOTTY;
  V4l2Ask ask = ask_for(64, 48);
  ask.rate_hz = 50;
  ask.rate_required = true;
  const V4l2Plan plan = planned(device, ask);
  EXPECT_TRUE(noted(plan, "frame rate cannot be set or read"));
  EXPECT_EQ(plan.settings.period_ns(), 20'000'000);
  EXPECT_FALSE(plan.settings.set_interval);
}

TEST(V4l2Plan, WorksWithMultiPlanarDevices) {
  ScriptedV4l2Device device;
  device.capabilities = V4L2_CAP_VIDEO_CAPTURE_MPLANE | V4L2_CAP_STREAMING;
  device.formats = {{V4L2_PIX_FMT_NV12M}};
  const V4l2Plan plan = planned(device, ask_for(64, 48));
  EXPECT_TRUE(plan.settings.multi_planar);
  EXPECT_EQ(plan.format.name, "NV12");
}

TEST(V4l2Plan, ListsRangesAndNamesCodes) {
  V4l2Size range{1920, 1080, 320, 180, 2, 2, {{1, 60}, true}};
  EXPECT_EQ(offers_text(
                {{V4L2_PIX_FMT_GREY, "", false, {range}}, {V4L2_PIX_FMT_Y10, "", false, {}}, {V4L2_PIX_FMT_H264, "", true, {}}},
                "  ", "640x480"),
            "  GREY 320x180 to 1920x1080 (1 to 60 Hz)\n  Y10 640x480\n  not usable: H264");
  EXPECT_EQ(offers_text({}, "  ", ""), "  nothing");
  EXPECT_EQ(fourcc_text(V4L2_PIX_FMT_Y10), "Y10");
  EXPECT_EQ(
      v4l2_format_names(),
      "auto, GREY, Y10, Y12, Y16, Y10P, YUYV, NV12, MJPG, SBGGR8, SGBRG8, SGRBG8, SRGGB8, SBGGR10, SGBRG10, SGRBG10, SRGGB10, "
      "SBGGR10P, SGBRG10P, SGRBG10P, SRGGB10P");
}

}  // namespace
}  // namespace srd
