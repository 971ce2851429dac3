// SPDX-License-Identifier: Apache-2.0
#include "firmware/config/camera_section.hpp"

#include <gtest/gtest.h>

#include "firmware/config/camera_factory.hpp"
#include "firmware/config/instrument.hpp"
#include "tests/fakes/test_data.hpp"

namespace srd::firmware {
namespace {

NodeConfig parsed(const std::string& camera, const std::string& rest = {}) {
  auto config = NodeConfig::parse("[surface]\nguess_mm = [80]\nlx_mm = 240\nly_mm = 440\n[camera]\n" + camera + rest, "n.toml");
  EXPECT_TRUE(config.ok()) << config.error().text();
  return config ? *config : NodeConfig{};
}

const std::string kFolder = fakes::test_data().string() + "/flume-small";
const std::string kGeometry = "[geometry]\ncalibration = \"" + kFolder + "/calibration.yml\"\npose = \"" + kFolder +
                              "/pose.yml\"\npoints = \"" + kFolder + "/points.txt\"\n";

TEST(CameraSection, HasDefaultsThatChangeNothingOfTheCamera) {
  const NodeConfig config = parsed("source = \"v4l2:/dev/video0\"\n");
  EXPECT_EQ(config.camera->kind, "v4l2");
  EXPECT_EQ(config.camera->argument, "/dev/video0");
  EXPECT_TRUE(config.camera->live());
  EXPECT_EQ(config.frame_rate_hz, 50);
  EXPECT_FALSE(config.live.rate_required);
  EXPECT_EQ(config.live.format, "auto");
  EXPECT_FALSE(config.live.exposure_us || config.live.gain || config.live.width || config.live.height || config.live.stamp);
  EXPECT_FALSE(config.live.sharpness || config.live.focus);
  EXPECT_EQ(config.live.buffers, 4);
  EXPECT_EQ(config.live.shutter, Shutter::kGlobal);
  EXPECT_FALSE(config.live.trigger_input);
}

TEST(CameraSection, ReadsEveryKey) {
  const NodeConfig config = parsed(
      "source = \"libcamera:imx296\"\nframe_rate_hz = 60\nformat = \"Y10\"\nwidth_px = 640\nheight_px = 320\nexposure_us = "
      "1500\n"
      "gain = 2.5\nsharpness = 0.5\nfocus = 3.25\nbuffers = 8\nshutter = \"rolling\"\nreadout_us = 9000\nstamp = "
      "\"exposure-start\"\ntrigger_input = true\nbits = 12\n");
  EXPECT_EQ(config.camera->text(), "libcamera:imx296");
  EXPECT_EQ(config.frame_rate_hz, 60);
  EXPECT_TRUE(config.live.rate_required);
  EXPECT_EQ(config.live.format, "Y10");
  EXPECT_EQ(config.live.width, 640);
  EXPECT_EQ(config.live.height, 320);
  EXPECT_EQ(config.live.exposure_us, 1500);
  EXPECT_EQ(config.live.gain, 2.5);
  EXPECT_EQ(config.live.sharpness, 0.5);
  EXPECT_EQ(config.live.focus, 3.25);
  EXPECT_EQ(config.live.buffers, 8);
  EXPECT_EQ(config.live.shutter, Shutter::kRolling);
  EXPECT_EQ(config.live.readout_us, 9000);
  EXPECT_EQ(config.live.stamp, StampMark::kExposureStart);
  EXPECT_TRUE(config.live.trigger_input);
  EXPECT_EQ(config.recording_bits, 12);
}

TEST(CameraSource, IsWrittenAsItIsRead) {
  for (const char* text :
       {"libcamera", "libcamera:/base/soc/i2c0mux/imx296@1a", "v4l2:/dev/v4l/by-id/usb-1", "recording:a:b", "simulator:7"}) {
    const auto source = CameraSource::parse(text);
    ASSERT_TRUE(source.ok()) << text;
    EXPECT_EQ(source->text(), text);
  }
}

TEST(CameraFactory, MakesALiveCameraThatFitsTheCalibrationWithoutOpeningIt) {
  const auto instrument = make_instrument(parsed("source = \"v4l2:/dev/no-such-camera\"\n", kGeometry));
  ASSERT_TRUE(instrument.ok()) << instrument.error().text();
  EXPECT_TRUE(instrument->camera->live());
  EXPECT_NE(instrument->summary.find("v4l2:/dev/no-such-camera, 640 x 320"), std::string::npos) << instrument->summary;
  const auto started = instrument->camera->start();
  ASSERT_FALSE(started.ok());
  EXPECT_EQ(started.error().exit, Exit::kDevice);
}

TEST(CameraFactory, ALiveCameraNeedsItsGeometry) {
  const auto instrument = make_instrument(parsed("source = \"v4l2:/dev/video0\"\n"));
  ASSERT_FALSE(instrument.ok());
  EXPECT_EQ(instrument.error().exit, Exit::kUsage);
  EXPECT_NE(instrument.error().text().find("geometry.calibration"), std::string::npos) << instrument.error().text();
}

TEST(CameraFactory, ListsTheKindsAndTheCamerasThatAreThere) {
  const std::string list = list_cameras();
  for (const char* part : {"libcamera[:ID]", "v4l2:/dev/videoN", "recording:FOLDER", "simulator[:SEED]",
                           "V4L2 capture devices:\n", "libcamera cameras:\n"})
    EXPECT_NE(list.find(part), std::string::npos) << part << " in " << list;
}

}  // namespace
}  // namespace srd::firmware
