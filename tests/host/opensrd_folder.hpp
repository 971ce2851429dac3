// SPDX-License-Identifier: Apache-2.0
// A lab's OpenSRD folder with known truth, and srd reconstruct run on it as a person would.
#pragma once

#include <gtest/gtest.h>

#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "drivers/geometry/calibration.hpp"
#include "drivers/geometry/points.hpp"
#include "drivers/geometry/pose.hpp"
#include "drivers/support/csv_table.hpp"
#include "drivers/support/text_file.hpp"
#include "host/reconstruct/command.hpp"
#include "tests/fakes/command_run.hpp"
#include "tests/fakes/scratch_folder.hpp"
#include "tests/fakes/synthetic_scene.hpp"

namespace srd::host {

using Keys = std::map<std::string, std::string>;

inline std::string settings_text(const Keys& keys) {
  std::string text = "<?xml version=\"1.0\"?>\n<opencv_storage>\n<Settings>\n";
  for (const auto& [key, value] : keys) text += "  <" + key + ">" + value + "</" + key + ">\n";
  return text + "</Settings>\n</opencv_storage>\n";
}

inline std::string quoted(const std::string& text) { return "\"" + text + "\""; }

inline std::string list_text(int count, double first, double others) {
  std::string text = "\"[" + number_text(first);
  for (int i = 1; i < count; ++i) text += "," + number_text(others);
  return text + "]\"";
}

// Settings of the 2016 code for feature files and pose files of so many cameras.
inline Keys keys_2016(int cameras, int parameters, double guess_mm = 70) {
  Keys keys = {{"NumberOfCameras", std::to_string(cameras)},
               {"TypeCameraPose", "0"},
               {"TypeFeatureInput", "0"},
               {"ThreadAmount", "2"},
               {"FeaturePatternSize_Width", "11"},
               {"FeaturePatternSize_Height", "21"},
               {"Lx", "240"},
               {"Ly", "440"},
               {"SurfaceModelParameters", std::to_string(parameters)},
               {"InitialGuess", list_text(parameters, guess_mm, 0)},
               {"Scaling", list_text(parameters, 1, 1)},
               {"ErrorMetric", "2"},
               {"Epsg", "0.000001"},
               {"Epsf", "0"},
               {"Epsx", "0"},
               {"MaxIts", "0"},
               {"OutputFileName", quoted("Coefficients.txt")},
               {"OutputFileNameResiudals", quoted("Errors.txt")}};
  for (int i = 1; i <= cameras; ++i) {
    const std::string n = std::to_string(i);
    keys["CalibrationFile" + n] = quoted("Calib_C" + n + ".yml");
    keys["InputReference" + n] = quoted("Pose_" + n + ".txt");
    keys["InputFeatures" + n] = quoted("FeaturesF_" + n + ".txt");
    keys["InputDirectory" + n] = quoted("DATA/CAM_" + n);
    keys["OutputCameraPose" + n] = quoted("Camera_Pose_" + n + ".txt");
    keys["OutputDirectory" + n] = quoted("FEATURES_" + n);
  }
  return keys;
}

using CommandResult = fakes::CommandRun;

inline CommandResult run_command(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), "reconstruct");
  return fakes::run_command(add_reconstruct_command, std::move(arguments));
}

class OpenSrdFolder {
 public:
  // Calibrations, poses and points of the scene, and keys_2016; feature files are added frame by frame.
  explicit OpenSrdFolder(const fakes::Scene& of, double guess_mm = 70)
      : scene(of), keys(keys_2016(static_cast<int>(of.views.size()), of.parameters(), guess_mm)) {
    for (std::size_t c = 0; c < scene.views.size(); ++c) {
      const std::string n = std::to_string(c + 1);
      const auto& k = scene.views[c].camera.distortion();
      std::filesystem::create_directories(path() / "INPUT");
      EXPECT_TRUE(write_calibration(path() / "INPUT" / ("Calib_C" + n + ".yml"),
                                    {scene.views[c].camera, std::vector<double>(k.begin(), k.end()), 1280, 640}));
      EXPECT_TRUE(write_pose(path() / "INPUT" / ("Pose_" + n + ".txt"), scene.views[c].pose));
      EXPECT_TRUE(write_points(path() / "INPUT" / ("FeaturesF_" + n + ".txt"), scene.points));
    }
  }

  // Features of all cameras of a frame of this true surface, with Gaussian noise of noise_px an axis.
  void add_frame(const fakes::Coefficients<double>& truth, double noise_px = 0, unsigned seed = 1) {
    scene.truth = truth;
    truths.push_back(truth);
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal(0, noise_px > 0 ? noise_px : 1);
    for (std::size_t c = 0; c < scene.views.size(); ++c) {
      std::string text;
      const auto& camera = scene.views[c].camera;
      for (std::size_t i = 0; i < scene.points.size(); ++i) {
        const auto xy = scene.seen(c, scene.points[i]);
        const double u = camera.fx() * xy.x() + camera.cx() + (noise_px > 0 ? normal(random) : 0);
        const double v = camera.fy() * xy.y() + camera.cy() + (noise_px > 0 ? normal(random) : 0);
        text += std::to_string(i) + "\t" + number_text(u) + "\t" + number_text(v) + "\n";
      }
      write(feature_file(c, truths.size() - 1), text);
    }
  }
  [[nodiscard]] static std::string feature_file(std::size_t camera, std::size_t frame) {
    const std::string digits = std::to_string(frame);
    return "DATA/CAM_" + std::to_string(camera + 1) + "/f" + std::string(4 - digits.size(), '0') + digits + ".txt";
  }

  std::filesystem::path write(const std::string& name, const std::string& text) const { return folder_.write(name, text); }
  [[nodiscard]] const std::filesystem::path& path() const { return folder_.path(); }
  [[nodiscard]] std::filesystem::path out() const { return path() / "out"; }

  // srd reconstruct settings.xml --out out, with further arguments.
  [[nodiscard]] CommandResult run(std::vector<std::string> more = {}) const {
    std::vector<std::string> arguments = {write("settings.xml", settings_text(keys)).string(), "--out", out().string()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_command(arguments);
  }
  [[nodiscard]] std::string result(const std::string& name) const { return fakes::bytes_of(out() / name); }

  fakes::Scene scene;
  Keys keys;
  std::vector<fakes::Coefficients<double>> truths;  // chronological

 private:
  fakes::ScratchFolder folder_;
};

// "[a0,a1,..]" lines as numbers.
inline std::vector<fakes::Coefficients<double>> coefficient_lines(const std::string& text) {
  std::vector<fakes::Coefficients<double>> lines;
  for (const TextLine& line : split_lines(text)) {
    std::string bare(line.text);
    for (const char bracket : {'[', ']'}) std::erase(bare, bracket);
    std::vector<double> numbers;
    for (const std::string_view field : split_commas(bare))
      numbers.push_back(parse_number<double>(field).value_or(std::nan("")));
    lines.push_back(Eigen::Map<const Eigen::VectorXd>(numbers.data(), static_cast<Eigen::Index>(numbers.size())));
  }
  return lines;
}

// Chronological coefficients of surface.csv, with all its decimals.
inline std::vector<fakes::Coefficients<double>> series_coefficients(const std::filesystem::path& csv,
                                                                    const dsp::ModeList& modes) {
  const auto table = CsvTable::read(csv);
  EXPECT_TRUE(table) << table.error().text();
  std::vector<fakes::Coefficients<double>> rows(table->rows(), fakes::Coefficients<double>(modes.size()));
  for (int j = 0; j < modes.size(); ++j) {
    const auto column = table->numbers(modes[j].name().data());
    EXPECT_TRUE(column) << column.error().text();
    for (std::size_t i = 0; i < rows.size(); ++i) rows[i][j] = (*column)[i];
  }
  return rows;
}

// rms over points of the difference of two surfaces, mm.
inline double surface_rms(const dsp::SurfaceModel<double>& model, const Points& points, const fakes::Coefficients<double>& a,
                          const fakes::Coefficients<double>& b) {
  double sum = 0;
  for (const auto& p : points) {
    const double e = model.height(a, p.x(), p.y()) - model.height(b, p.x(), p.y());
    sum += e * e;
  }
  return std::sqrt(sum / static_cast<double>(points.size()));
}

// The lab's recordings; nothing where they are not.
inline std::optional<std::filesystem::path> lab_data() {
  const std::filesystem::path root = fakes::lab_data();
  if (!std::filesystem::is_directory(root)) return std::nullopt;
  return root;
}

}  // namespace srd::host
