// SPDX-License-Identifier: Apache-2.0
// A run that measures nothing ends with what is wrong with its images. Each kind is made of frames that measure well.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "drivers/recording/image_file.hpp"
#include "tests/fakes/test_data.hpp"
#include "tests/host/opensrd_folder.hpp"

namespace srd::host {
namespace {

constexpr int kFrames = 2;

using Change = std::function<void(GrayImage&)>;

// Each pixel from its place in the image and its grey level.
Change each(std::function<double(int u, int v, double grey)> change) {
  return [change = std::move(change)](GrayImage& image) {
    for (int v = 0; v < image.height; ++v)
      for (int u = 0; u < image.width; ++u) {
        std::uint8_t& pixel = image.pixels[static_cast<std::size_t>(v * image.width + u)];
        pixel = static_cast<std::uint8_t>(std::clamp(std::lround(change(u, v, pixel)), 0L, 255L));
      }
  };
}

void flip_rows(GrayImage& image) {
  for (int v = 0; v < image.height / 2; ++v)
    std::swap_ranges(image.pixels.begin() + v * image.width, image.pixels.begin() + (v + 1) * image.width,
                     image.pixels.begin() + (image.height - 1 - v) * image.width);
}
void flip_columns(GrayImage& image) {
  for (int v = 0; v < image.height; ++v)
    std::reverse(image.pixels.begin() + v * image.width, image.pixels.begin() + (v + 1) * image.width);
}
// Means of 2 x half + 1 pixels along rows, then along columns.
void average(GrayImage& image, int half) {
  for (const bool along : {true, false}) {
    const std::vector<std::uint8_t> before = image.pixels;
    for (int v = 0; v < image.height; ++v)
      for (int u = 0; u < image.width; ++u) {
        int sum = 0;
        for (int k = -half; k <= half; ++k) {
          const int x = std::clamp(u + (along ? k : 0), 0, image.width - 1),
                    y = std::clamp(v + (along ? 0 : k), 0, image.height - 1);
          sum += before[static_cast<std::size_t>(y * image.width + x)];
        }
        image.pixels[static_cast<std::size_t>(v * image.width + u)] = static_cast<std::uint8_t>(sum / (2 * half + 1));
      }
  }
}

// The first frames of the small recording, changed, without the dry reference.
class ChangedRecording {
 public:
  explicit ChangedRecording(const Change& change) {
    const auto from = fakes::test_data() / "flume-small";
    for (const char* name : {"calibration.yml", "pose.yml", "points.txt", "optics.toml"})
      std::filesystem::copy_file(from / name, folder_.path() / name);
    for (int i = 0; i < kFrames; ++i) {
      auto image = read_gray_image(from / ("frame_00000" + std::to_string(i) + ".png"));
      EXPECT_TRUE(image);
      change(*image);
      EXPECT_TRUE(write_gray_image(folder_.path() / ("frame_" + std::to_string(i) + ".pgm"), image->view()));
    }
  }
  [[nodiscard]] std::filesystem::path path() const { return folder_.path(); }
  [[nodiscard]] CommandResult reconstruct(const std::vector<std::string>& more = {}) const {
    std::vector<std::string> arguments = {path().string(), "--out", (path() / "out").string(), "--guess", "80", "--rate", "50"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_command(arguments);
  }

 private:
  fakes::ScratchFolder folder_;
};

struct Fault {
  const char* name;
  Change change;
  const char* said;
};
void PrintTo(const Fault& fault, std::ostream* out) { *out << fault.name; }

class ReconstructDiagnosis : public testing::TestWithParam<Fault> {};

TEST_P(ReconstructDiagnosis, SaysWhatIsWrongWithTheImages) {
  const ChangedRecording recording(GetParam().change);
  const CommandResult done = recording.reconstruct();
  EXPECT_EQ(done.exit, 3) << done.out;
  EXPECT_NE(done.err.find("no frame gave a surface"), std::string::npos) << done.err;
  EXPECT_NE(done.err.find(GetParam().said), std::string::npos) << done.err;
  EXPECT_NE(done.err.find("frame_0.pgm"), std::string::npos) << "the file: " << done.err;
}

INSTANTIATE_TEST_SUITE_P(
    Reconstruct, ReconstructDiagnosis,
    testing::Values(Fault{"Mosaic", each([](int u, int v, double grey) {
                            return grey * (u % 2 == v % 2 ? (u % 2 == 0 ? 0.25 : 0.1) : 1.0);
                          }),
                          "mosaic of a colour sensor"},
                    Fault{"Dark", each([](int, int, double grey) { return grey * 0.13; }), "too dark"},
                    Fault{"Bright", each([](int, int, double grey) { return 240 + 4 * grey; }), "too bright"},
                    Fault{"Blurred",
                          [](GrayImage& image) {
                            average(image, 9);
                            average(image, 9);
                          },
                          "blurred"},
                    Fault{"NoBoard", each([](int u, int, double) { return u / 16 % 2 == 0 ? 30 : 220; }), "shows no board"},
                    Fault{"PartOfTheBoard", each([](int u, int v, double grey) { return u < 125 && v < 90 ? grey : 40; }),
                          "does not show the whole board"},
                    Fault{"UpsideDown", flip_rows, "upside down"}, Fault{"Mirrored", flip_columns, "mirrored"},
                    Fault{"HalfTurn",
                          [](GrayImage& image) {
                            flip_rows(image);
                            flip_columns(image);
                          },
                          "half a turn"}),
    [](const testing::TestParamInfo<Fault>& test) { return std::string(test.param.name); });

TEST(ReconstructDiagnosis, UnchangedFramesMeasure) {
  const ChangedRecording recording([](GrayImage&) {});
  const CommandResult done = recording.reconstruct();
  EXPECT_EQ(done.exit, 0) << done.err;
}

TEST(ReconstructDiagnosis, NamesColoursThatAreSwappedWhereNotTheWholeBoardTellsThem) {
  const ChangedRecording recording(each([](int u, int v, double grey) { return u < 110 && v < 70 ? 128 : 255 - grey; }));
  const CommandResult done = recording.reconstruct();
  EXPECT_EQ(done.exit, 3) << done.out;
  EXPECT_NE(done.err.find("black and white are swapped"), std::string::npos) << done.err;
}

// 12 bits in samples of 16, as many programs save them: nearly black, and right when their bits are given.
TEST(ReconstructDiagnosis, NamesTheBitsOfSamplesAtTheLowerEnd) {
  const ChangedRecording recording([](GrayImage&) {});
  for (int i = 0; i < kFrames; ++i) {
    const auto file = recording.path() / ("frame_" + std::to_string(i) + ".pgm");
    const auto image = read_gray_image(file);
    ASSERT_TRUE(image);
    std::string text = "P5\n" + std::to_string(image->width) + " " + std::to_string(image->height) + "\n65535\n";
    for (const std::uint8_t pixel : image->pixels) {
      const int sample = 16 * pixel + 7;
      text += static_cast<char>(sample >> 8);
      text += static_cast<char>(sample & 255);
    }
    ASSERT_TRUE(write_text_file(file, text));
  }
  const CommandResult black = recording.reconstruct();
  EXPECT_EQ(black.exit, 3) << black.out;
  EXPECT_NE(black.err.find("--bits 12"), std::string::npos) << black.err;
  const CommandResult done = recording.reconstruct({"--bits", "12", "--force"});
  EXPECT_EQ(done.exit, 0) << done.err;
  EXPECT_EQ(done.err.find("--bits"), std::string::npos) << done.err;
  const ChangedRecording plain([](GrayImage&) {});
  ASSERT_EQ(plain.reconstruct().exit, 0);
  EXPECT_EQ(fakes::bytes_of(recording.path() / "out/surface.csv"), fakes::bytes_of(plain.path() / "out/surface.csv"))
      << "the same grey levels, the same surface";
}

}  // namespace
}  // namespace srd::host
