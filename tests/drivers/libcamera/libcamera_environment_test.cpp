// SPDX-License-Identifier: Apache-2.0
#include "drivers/camera/libcamera/libcamera_environment.hpp"

#include <gtest/gtest.h>

#include <cstdlib>

#include "tests/fakes/scratch_folder.hpp"

namespace srd {
namespace {

using namespace std::string_literals;

// The variables as they were, after each test.
class LibcameraEnvironment : public testing::Test {
 protected:
  static constexpr const char* kNames[] = {"LIBCAMERA_LOG_LEVELS", "LIBCAMERA_RPI_CONFIG_FILE", "LIBCAMERA_LOG_FILE"};
  void SetUp() override {
    for (std::size_t i = 0; i < 3; ++i) {
      const char* value = std::getenv(kNames[i]);
      had_[i] = value != nullptr;
      before_[i] = had_[i] ? value : "";
      ::unsetenv(kNames[i]);
    }
  }
  void TearDown() override {
    for (std::size_t i = 0; i < 3; ++i)
      if (had_[i])
        ::setenv(kNames[i], before_[i].c_str(), 1);
      else
        ::unsetenv(kNames[i]);
  }
  void board(const std::string& compatible) { scratch_.write("proc/device-tree/compatible", compatible); }

  fakes::ScratchFolder scratch_;

 private:
  bool had_[3] = {};
  std::string before_[3];
};

TEST_F(LibcameraEnvironment, KnowsTheBoardsByTheirProcessor) {
  EXPECT_EQ(raspberrypi_target("raspberrypi,5-model-b\0brcm,bcm2712\0"s), "pisp");
  EXPECT_EQ(raspberrypi_target("raspberrypi,4-model-b\0brcm,bcm2711\0"s), "bcm2835");
  EXPECT_EQ(raspberrypi_target("raspberrypi,3-model-b\0brcm,bcm2837\0"s), "bcm2835");
  EXPECT_EQ(raspberrypi_target("linux,dummy-virt\0"s), "");
  EXPECT_EQ(raspberrypi_target("maker,brcm,bcm27120\0"s), "");
  EXPECT_EQ(raspberrypi_target(""), "");
}

TEST_F(LibcameraEnvironment, OnlyErrorsAreLoggedUnlessTheUserSaysOtherwise) {
  prepare_libcamera(false, scratch_.path());
  EXPECT_STREQ(std::getenv("LIBCAMERA_LOG_LEVELS"), "*:ERROR");
  EXPECT_EQ(std::getenv("LIBCAMERA_RPI_CONFIG_FILE"), nullptr);
  ASSERT_EQ(libcamera_settings(false, scratch_.path()).size(), 1u);
  EXPECT_NE(libcamera_settings(false, scratch_.path())[0].found.find("*:INFO in the environment shows more"),
            std::string::npos);
  ::setenv("LIBCAMERA_LOG_LEVELS", "RPI:DEBUG", 1);
  ::setenv("LIBCAMERA_LOG_FILE", "/tmp/camera.log", 1);
  prepare_libcamera(false, scratch_.path());
  EXPECT_STREQ(std::getenv("LIBCAMERA_LOG_LEVELS"), "RPI:DEBUG");
  EXPECT_EQ(libcamera_settings(false, scratch_.path())[0].found, "LIBCAMERA_LOG_LEVELS=RPI:DEBUG, to /tmp/camera.log");
}

TEST_F(LibcameraEnvironment, ATriggeredCameraOfARaspberryPiMayWait) {
  for (const auto& [compatible, target] : {std::pair{"raspberrypi,5-model-b\0brcm,bcm2712\0"s, "\"pisp\""},
                                           std::pair{"raspberrypi,4-model-b\0brcm,bcm2711\0"s, "\"bcm2835\""}}) {
    board(compatible);
    ::unsetenv("LIBCAMERA_RPI_CONFIG_FILE");
    ASSERT_EQ(libcamera_settings(true, scratch_.path()).size(), 2u);
    EXPECT_NE(libcamera_settings(true, scratch_.path())[1].advice, "") << "libcamera's own limit";
    prepare_libcamera(false, scratch_.path());
    EXPECT_EQ(std::getenv("LIBCAMERA_RPI_CONFIG_FILE"), nullptr) << "a camera that runs by itself keeps its limit";
    prepare_libcamera(true, scratch_.path());
    const char* file = std::getenv("LIBCAMERA_RPI_CONFIG_FILE");
    ASSERT_NE(file, nullptr);
    for (int again = 0; again < 2; ++again) {
      const std::string text = fakes::bytes_of(file);
      EXPECT_NE(text.find("\"target\": "s + target), std::string::npos) << text;
      EXPECT_NE(text.find("\"camera_timeout_value_ms\": 86400000"), std::string::npos) << text;
    }
    EXPECT_EQ(libcamera_settings(true, scratch_.path())[1].advice, "");
  }
}

TEST_F(LibcameraEnvironment, AConfigurationOfTheUsersStaysAndIsLookedInto) {
  board("brcm,bcm2711\0"s);
  const auto file = scratch_.write("mine.yaml", "{ \"version\": 1.0,\n  # \"camera_timeout_value_ms\": 5000,\n}\n");
  ::setenv("LIBCAMERA_RPI_CONFIG_FILE", file.c_str(), 1);
  prepare_libcamera(true, scratch_.path());
  EXPECT_EQ(std::getenv("LIBCAMERA_RPI_CONFIG_FILE"), file.string());
  EXPECT_NE(libcamera_settings(true, scratch_.path())[1].advice.find("camera_timeout_value_ms"), std::string::npos);
  scratch_.write("mine.yaml", "{ \"version\": 1.0,\n  \"camera_timeout_value_ms\": 5000,\n}\n");
  EXPECT_EQ(libcamera_settings(true, scratch_.path())[1].advice, "");
}

TEST_F(LibcameraEnvironment, AnotherBoardHasNoSuchLimit) {
  board("linux,dummy-virt\0"s);
  prepare_libcamera(true, scratch_.path());
  EXPECT_EQ(std::getenv("LIBCAMERA_RPI_CONFIG_FILE"), nullptr);
  EXPECT_EQ(libcamera_settings(true, scratch_.path()).size(), 1u);
}

}  // namespace
}  // namespace srd
