// SPDX-License-Identifier: Apache-2.0
// Images that OpenCV wrote, through our readers and through OpenCV's.
#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>
#include <random>

#include "drivers/recording/image_file.hpp"
#include "tests/fakes/scratch_folder.hpp"

namespace srd {
namespace {

using fakes::bytes_of;
using fakes::ScratchFolder;

TEST(OtherImages, CutOnesAreRefused) {
  const ScratchFolder folder;
  cv::Mat mat(48, 64, CV_8UC1);
  std::mt19937 random(3);
  for (int i = 0; i < 48 * 64; ++i) mat.at<std::uint8_t>(i / 64, i % 64) = static_cast<std::uint8_t>(random());
  for (const char* name : {"a.png", "a.pgm", "a.bmp", "a.jpg", "a.tif"}) {
    const auto file = folder.path() / name;
    ASSERT_TRUE(cv::imwrite(file.string(), mat));
    ASSERT_TRUE(read_gray_image(file)) << name;
    const std::string whole = bytes_of(file);
    for (const double part : {0.0, 0.1, 0.5, 0.9}) {
      folder.write(name, whole.substr(0, static_cast<std::size_t>(part * static_cast<double>(whole.size()))));
      EXPECT_FALSE(read_gray_image(file)) << name << " " << part;
      std::vector<std::uint8_t> pixels(64 * 48);
      EXPECT_FALSE(read_gray_image_into(file.string(), {pixels.data(), 64, 48, 64})) << name << " " << part;
    }
  }
}

TEST(OtherImages, SixteenBitsAreShiftedToEight) {
  const ScratchFolder folder;
  cv::Mat wide(5, 7, CV_16UC1);
  for (int i = 0; i < 35; ++i) wide.at<std::uint16_t>(i / 7, i % 7) = static_cast<std::uint16_t>(i * 1800 + 255);
  ASSERT_TRUE(cv::imwrite((folder.path() / "a.png").string(), wide));
  ASSERT_TRUE(cv::imwrite((folder.path() / "a.pgm").string(), wide));
  for (const char* name : {"a.png", "a.pgm"}) {
    const auto image = read_gray_image(folder.path() / name);
    ASSERT_TRUE(image);
    for (int i = 0; i < 35; ++i) EXPECT_EQ(image->pixels[static_cast<std::size_t>(i)], (i * 1800 + 255) >> 8) << name;
  }
}

TEST(OtherImages, TwelveBitsAtTheLowerEndOfSixteen) {
  const ScratchFolder folder;
  cv::Mat wide(5, 7, CV_16UC1);
  for (int i = 0; i < 35; ++i) wide.at<std::uint16_t>(i / 7, i % 7) = static_cast<std::uint16_t>(i * 117);
  for (const char* name : {"a.png", "a.pgm", "a.tif"}) {
    const auto file = folder.path() / name;
    ASSERT_TRUE(cv::imwrite(file.string(), wide));
    const auto black = read_gray_image(file), right = read_gray_image(file, 12);
    ASSERT_TRUE(black && right) << name;
    EXPECT_EQ(bits_at_lower_end(*black), 12) << name;
    EXPECT_EQ(bits_at_lower_end(*right), std::nullopt) << name;
    for (int i = 0; i < 35; ++i) EXPECT_EQ(right->pixels[static_cast<std::size_t>(i)], (i * 117) >> 4) << name;
  }
}

TEST(OtherImages, ColourBecomesGrey) {
  const ScratchFolder folder;
  const cv::Mat colour(3, 4, CV_8UC3, cv::Scalar(30, 70, 200));
  for (const char* name : {"a.png", "a.bmp", "a.tif"}) {
    const std::string file = (folder.path() / name).string();
    ASSERT_TRUE(cv::imwrite(file, colour));
    const cv::Mat expected = cv::imread(file, cv::IMREAD_GRAYSCALE);
    const auto image = read_gray_image(file);
    ASSERT_TRUE(image);
    ASSERT_EQ(image->pixels.size(), 12U);
    for (int i = 0; i < 12; ++i)
      EXPECT_NEAR(image->pixels[static_cast<std::size_t>(i)], expected.at<std::uint8_t>(i / 4, i % 4), 1) << name;
  }
}

TEST(OtherImages, ContentsDecideNotTheEnding) {
  const ScratchFolder folder;
  const cv::Mat mat(5, 7, CV_8UC1, cv::Scalar(90));
  ASSERT_TRUE(cv::imwrite((folder.path() / "a.png").string(), mat));
  ASSERT_TRUE(cv::imwrite((folder.path() / "a.bmp").string(), mat));
  for (const char* name : {"a.png", "a.bmp"}) {
    folder.write("b.pgm", bytes_of(folder.path() / name));
    const auto image = read_gray_image(folder.path() / "b.pgm");
    ASSERT_TRUE(image) << name;
    EXPECT_EQ(image->pixels, std::vector<std::uint8_t>(35, 90));
  }
}

}  // namespace
}  // namespace srd
