// SPDX-License-Identifier: Apache-2.0
// A recording: a folder with images and frames.csv (file,sequence,time_ns,exposure_us,strobe), and beside
// them calibration.yml, pose.yml, points.txt, truth.csv, reference.png where they are known. Without
// frames.csv the images are taken in natural order (natural_order.hpp) at a rate that the caller gives.
#pragma once

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/recording/image_file.hpp"
#include "drivers/support/problem.hpp"
#include "dsp/core/time.hpp"

namespace srd {

// Names of the files in a recording.
inline constexpr std::string_view kFramesName = "frames.csv";
inline constexpr std::string_view kCalibrationName = "calibration.yml";
inline constexpr std::string_view kPoseName = "pose.yml";
inline constexpr std::string_view kPointsName = "points.txt";
inline constexpr std::string_view kTruthName = "truth.csv";
inline constexpr std::string_view kReferenceName = "reference.png";

inline constexpr std::string_view kFramesHeader = "file,sequence,time_ns,exposure_us,strobe";

// A row of frames.csv.
struct RecordedFrame {
  std::string file{};                            // in the folder, or in one below it
  std::uint64_t sequence = 0;                    // grows from row to row
  std::int64_t time_ns = 0;                      // middle of the light; never falls
  std::uint32_t exposure_us = 0;                 // 0: unknown
  StrobePhase strobe = StrobePhase::kUnstrobed;  // 0, 1 lit, 2 dark
};

struct Recording {
  std::filesystem::path folder;
  std::vector<RecordedFrame> frames;
  bool listed = false;               // frames.csv was there
  bool cut = false;                  // its last line was not whole and was left out: the recorder was interrupted
  std::vector<std::string> notes{};  // for a person: how order and times were come by where that is not plain
};

// Where the times of frames come from.
struct RecordingTimes {
  double rate_hz = 0;          // without frames.csv it must be > 0
  bool from_sequence = false;  // frames.csv's times are not used: the first frame's is 0, the rate gives the others'
};

// kInput: no folder, no frame, a wrong row (with its line). Whether the images can be read shows when they are read.
[[nodiscard]] Outcome<Recording> read_recording(const std::filesystem::path& folder, const RecordingTimes& times = {});

// The folder made, and the path of its frames.csv. kUsage when it holds a recording already and overwrite is false.
[[nodiscard]] Outcome<std::filesystem::path> make_recording_folder(const std::filesystem::path& folder, bool overwrite);

enum class ImageFormat : std::uint8_t { kPng, kPgm };

// Writes images and frames.csv, the image first: a recording cut at any moment is whole up to its last row.
// One thread. add reuses nothing of the frame after it returns.
class RecordingWriter {
 public:
  // Makes the folder. kUsage when it holds a recording already and overwrite is false. With overwrite,
  // frames.csv starts anew; images of the old recording that the new one does not replace stay, unlisted.
  [[nodiscard]] static Outcome<RecordingWriter> create(const std::filesystem::path& folder, ImageFormat format, bool overwrite);
  // frame.file is ignored: the writer names images frame_000000.png, frame_000001.png, ..
  [[nodiscard]] Outcome<void> add(const GrayView& image, const RecordedFrame& frame);
  [[nodiscard]] int frames() const { return frames_; }

 private:
  struct Closer {
    void operator()(std::FILE* file) const noexcept { (void)std::fclose(file); }
  };
  std::filesystem::path folder_;
  ImageFormat format_ = ImageFormat::kPng;
  std::unique_ptr<std::FILE, Closer> listing_;
  int frames_ = 0;
};

}  // namespace srd
