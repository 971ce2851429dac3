// SPDX-License-Identifier: Apache-2.0
// Files of a calibration: the calibration itself as OpenCV and OpenSRD read it, errors and provenance, pictures, a page.
#pragma once

#include "host/calibrate/calibration.hpp"

namespace srd::host {

struct CalibrationFiles {
  std::filesystem::path calibration, report, corners, uncertainty, page;
};

[[nodiscard]] CalibrationFiles calibration_files(const std::filesystem::path& out, const std::string& calibration_name);
// Makes the folder. kUsage: results are there already, unless force; the folder cannot be written.
[[nodiscard]] Outcome<void> prepare_folder(const std::filesystem::path& out, const CalibrationFiles& files, bool force);
[[nodiscard]] Outcome<void> write_results(const std::filesystem::path& out, const CalibrationFiles& files,
                                          const CalibrationResult& result);

// Standard errors, bend, checks and provenance as TOML.
[[nodiscard]] std::string report_toml(const CalibrationResult& result);
// Each corner: image, row, column, u, v, sigma, residuals, used or outlier.
[[nodiscard]] std::string corners_csv(const CalibrationResult& result);

// The maps' values: distance, u, v, deviation.
[[nodiscard]] std::string uncertainty_csv(const CalibrationResult& result);

}  // namespace srd::host
