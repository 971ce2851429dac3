// SPDX-License-Identifier: Apache-2.0
// The configuration of one node: a commented TOML file, checked as a whole before anything starts.
// board/ holds one profile a board; board/README.md lists every key.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "drivers/camera/camera.hpp"
#include "drivers/recording/recorded_optics.hpp"
#include "drivers/support/problem.hpp"
#include "dsp/pipeline/surface_tracker.hpp"
#include "firmware/config/camera_section.hpp"
#include "firmware/realtime/realtime_section.hpp"
#include "firmware/recording/recording_section.hpp"
#include "firmware/strobe/strobe_section.hpp"

namespace srd {
class TomlFile;
}

namespace srd::firmware {

// A regular grid of corners given in the configuration instead of a file of points. mm, W.
struct PatternGrid {
  int rows = 0, columns = 0;  // along X, along Y
  double square_mm = 0, x0_mm = 0, y0_mm = 0;
};

struct NodeConfig {
  std::filesystem::path file;

  std::string node_id = "node-1";  // at most 31 characters
  std::string host;                // ADDR:PORT; empty: nothing is sent
  std::filesystem::path key;       // file of the node's key; empty: the link has no keys
  std::size_t ring_frames = 10000;
  std::filesystem::path spill;  // folder for frames that the host does not have; empty: they are in memory alone
  std::filesystem::path state;  // folder for how the last run ended; empty: what the service manager gives

  std::optional<CameraSource> camera;
  Pace pace = Pace::kCamera;
  double frame_rate_hz = 50;                   // of a live camera, and of a recording without frames.csv
  int recording_bits = 0;                      // of samples of two bytes in a recording's images; 0: as read_gray_image
  std::optional<double> recording_rate_hz;     // the times of a recording follow from its sequence, at this rate
  std::optional<std::filesystem::path> scene;  // of the simulator; none: the built-in flume
  LiveCamera live;

  StrobeSection strobe;

  // Empty: what the camera brings along (a recording's folder, the simulator's scene).
  // "recording:PATH" is relative to the recording's folder, other paths to the configuration's.
  std::string calibration, pose, points;
  std::optional<PatternGrid> pattern;
  dsp::FirstSquare first_square = dsp::FirstSquare::kDark;

  // Empty: the simulator's own, or what is in the recording; else 20 C fresh water at 589 nm, no plates.
  std::optional<double> refractive_index;
  std::optional<Plates> plates;

  dsp::ModeList modes;
  // Empty: the simulator's own, or what is in the recording; else there must be lengths, and the origin is 0.
  std::optional<double> lx_mm, ly_mm, x0_mm, y0_mm;
  std::vector<double> guess;  // one a mode
  dsp::EstimatorOptions estimator;
  std::optional<std::int64_t> deadline_us;  // of a frame's processing; empty: none
  dsp::SurfaceTrackerOptions tracker;
  Region region;
  RealtimeSection realtime;
  RecordingSection recording;

  // All problems of the file in one Problem.
  [[nodiscard]] static Outcome<NodeConfig> load(const std::filesystem::path& file);
  [[nodiscard]] static Outcome<NodeConfig> parse(std::string_view text, const std::filesystem::path& file);

 private:
  [[nodiscard]] static Outcome<NodeConfig> read(const TomlFile& toml, const std::filesystem::path& file);
};

}  // namespace srd::firmware
