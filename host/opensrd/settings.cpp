// SPDX-License-Identifier: Apache-2.0
#include "host/opensrd/settings.hpp"

#include <algorithm>
#include <cmath>

#include "drivers/support/text_file.hpp"
#include "host/opensrd/xml_values.hpp"

namespace srd::host::opensrd {

namespace {

namespace fs = std::filesystem;

const KeyNames kCameras = {"CameraAmount", "NumberOfCameras"};
const KeyNames kParameters = {"SurfaceModel", "SurfaceModelParameters"};
const NumberRange kLength = {1e-6, 1e6, "mm"};
const NumberRange kTolerance = {0, 1e6, ""};
const int kLargestResponse = 2040;  // of optics (22): four sums of two grey levels, each against two
const NumberRange kCorners = {2, 1000, "inner corners"};

KeyNames numbered(const std::string& key, int camera) { return {key + std::to_string(camera)}; }

class Reader {
 public:
  explicit Reader(XmlValues values, fs::path file) : values_(std::move(values)) {
    settings_.file = std::move(file);
    settings_.dialect = dialect();
  }

  Outcome<Settings> read() {
    if (!values_.has({"OutputFileName"}) && values_.has({"Write_outputFileName"}))
      return Problem{Exit::kUsage,
                     "are settings of a calibration",
                     settings_.file.string(),
                     "settings of a reconstruction",
                     "key 'Write_outputFileName'",
                     "srd calibrate reads them"};
    ignore();
    flags();
    boards();
    model();
    optimiser();
    detector();
    cameras();
    outputs();
    if (auto good = values_.finish(); !good) return good.error();
    for (const std::string& key : values_.unknown())
      settings_.warnings.push_back(values_.where({key}) + ": unknown key '" + key + "' is ignored, as OpenSRD does");
    return settings_;
  }

 private:
  // By keys that only one dialect has.
  [[nodiscard]] Dialect dialect() const {
    for (const char* key : {"gridSize", "min_u", "max_u", "min_v", "max_v", "OutputFileCenters", "minThreshold"})
      if (values_.has({key})) return Dialect::k2017;
    for (const char* key : {"CameraAmount", "SurfaceModel", "InputTypeRef", "InputType", "InputInitial", "Square_Size",
                            "PatternSize_Width", "BoardSize_Width", "Position1"})
      if (values_.has({key})) return Dialect::kGuide;
    return Dialect::k2016;
  }
  [[nodiscard]] bool guide() const { return settings_.dialect == Dialect::kGuide; }
  [[nodiscard]] bool patch() const { return settings_.dialect == Dialect::k2017; }

  double number(const KeyNames& key, const NumberRange& range, const std::string& what) {
    const std::optional<double> x = values_.number(key, range);
    if (!x && !values_.has(key)) values_.missing(key, what);
    return x.value_or(0);
  }
  int integer(const KeyNames& key, const NumberRange& range, const std::string& what) {
    const std::optional<int> x = values_.integer(key, range);
    if (!x && !values_.has(key)) values_.missing(key, what);
    return x.value_or(0);
  }

  // Keys that have no effect here: results do not depend on threads, derivatives are exact, no window is opened.
  void ignore() {
    for (const char* key : {"ThreadAmount", "ShowCorners", "DiffStep"}) values_.know({key});
    for (int camera = 1; camera <= kMaxCameras; ++camera)
      for (const char* key : {"InputDirectory", "InputReference", "InputInitial", "InputFeatures", "CalibrationFile",
                              "OutputCameraPose", "OutputDirectory", "Position"})
        values_.know(numbered(key, camera));
    if (const auto show = values_.flag({"ShowCorners"}); show && *show)
      settings_.warnings.push_back(values_.where({"ShowCorners"}) + ": key '" + values_.name({"ShowCorners"}) +
                                   "' has no effect: no window is opened");
  }

  void flags() {
    settings_.pose_from_image = values_.flag({"InputTypeRef", "TypeCameraPose"}).value_or(true);
    settings_.features_from_images = values_.flag({"InputType", "TypeFeatureInput"}).value_or(true);
    settings_.save_pose = values_.flag({"SaveCameraPose"}).value_or(true);
    settings_.save_features = values_.flag({"SaveFeatureCoordinates"}).value_or(true);
    settings_.save_errors = values_.flag({"SaveErrors", "SaveResiduals"}).value_or(true);
  }

  PatternSize pattern_size(const std::string& first, const std::string& second) {
    const auto names = [&](const std::string& side) {
      return second.empty() ? KeyNames{first + side} : KeyNames{first + side, second + side};
    };
    return {integer(names("Width"), kCorners, "rows of inner corners"),
            integer(names("Height"), kCorners, "columns of inner corners")};
  }

  void boards() {
    if (settings_.pose_from_image) {
      settings_.board = pattern_size("BoardSize_", "RefPatternSize_");
      if (guide()) settings_.square_mm = number({"Square_Size"}, kLength, "side of a square of the board, mm");
    } else {
      for (const char* key :
           {"BoardSize_Width", "BoardSize_Height", "RefPatternSize_Width", "RefPatternSize_Height", "Square_Size"})
        values_.know({key});
    }
    if (!patch()) {
      settings_.pattern = pattern_size("PatternSize_", "FeaturePatternSize_");
      return;
    }
    PatchSettings& p = settings_.patch;
    const NumberRange levels{0, 255, "grey levels"};
    p.square_mm = number({"gridSize"}, kLength, "side of a square of the pattern, mm");
    p.dark_below = integer({"minThreshold"}, levels, "grey level below which a pixel is dark");
    p.bright_above = integer({"maxThreshold"}, levels, "grey level above which a pixel is bright");
  }

  void model() {
    settings_.lx = number({"Lx"}, kLength, "length scale along X, mm");
    settings_.ly = number({"Ly"}, kLength, "length scale along Y, mm");
    const KeyNames guess_key = {"InitialGuess"}, scale_key = {"Scaling"};
    std::optional<std::vector<double>> guess = values_.numbers(guess_key);
    if (!guess && !values_.has(guess_key)) values_.missing(guess_key, "the surface to start from, mm, as \"[70.0]\"");
    settings_.parameters = integer(kParameters, {1, 12, ""}, "1, 3, 5, 8 or 12");
    if (patch() && guess && guess->size() == 2) {
      // The release's own file asks for 3 and gives 2: the guess decides there.
      if (settings_.parameters != 2)
        settings_.warnings.push_back(values_.where(kParameters) + ": key '" + values_.name(kParameters) + "' is " +
                                     std::to_string(settings_.parameters) + ", but the guess has 2 numbers: 2 is used");
      settings_.parameters = 2;
    } else if (values_.has(kParameters) && !dsp::ModeList::standard(settings_.parameters)) {
      if (settings_.parameters != 0)
        values_.complain(kParameters, "1, 3, 5, 8 or 12 parameters", std::to_string(settings_.parameters));
      return;
    }
    const std::size_t n = static_cast<std::size_t>(settings_.parameters);
    if (guess && n > 0) {
      if (guess->size() > n)
        values_.complain(guess_key, "at most " + std::to_string(n) + " numbers, one a parameter",
                         std::to_string(guess->size()) + " numbers");
      guess->resize(n, 0.0);  // guide, Initialguess: a basic estimate is enough
      settings_.guess = *guess;
    }
    settings_.scale.assign(n, 1.0);
    const std::optional<std::vector<double>> scale = values_.numbers(scale_key);
    if (!scale) return;
    if (scale->size() != n)
      values_.complain(scale_key, std::to_string(n) + " numbers, one a parameter", std::to_string(scale->size()) + " numbers");
    else if (std::any_of(scale->begin(), scale->end(), [](double x) { return x <= 0; }))
      values_.complain(scale_key, "numbers above 0", "a number of 0 or less");
    else
      settings_.scale = *scale;
  }

  void optimiser() {
    settings_.epsg = values_.number({"Epsg"}, kTolerance).value_or(0);
    settings_.epsf = values_.number({"Epsf"}, kTolerance).value_or(0);
    settings_.epsx = values_.number({"Epsx"}, kTolerance).value_or(0);
    settings_.max_iterations = values_.integer({"MaxIts"}, {0, 1e6, ""}).value_or(0);
    if (patch()) return;  // pattern consistency is its only metric
    const int metric = integer({"ErrorMetric"}, {1, 2, ""}, "1 (normal collinearity) or 2 (disparity difference)");
    settings_.metric = metric == 1 ? dsp::Metric::kCollinearity : dsp::Metric::kDisparity;
  }

  void detector() {
    const KeyNames radius = {"ResponseRadius"}, threshold = {"ResponseThreshold"}, distance = {"MinDistance"};
    settings_.response_radius = values_.integer(radius, {1, 100, "px"}).value_or(5);
    if (const int r = settings_.response_radius; r != 5 && r != 10) values_.complain(radius, "5 or 10 px", std::to_string(r));
    settings_.response_threshold = values_.integer(threshold, {1, kLargestResponse, ""}).value_or(350);
    settings_.min_distance_px = values_.number(distance, {1, 1000, "px"}).value_or(15);
    settings_.match_radius_px = values_.number({"MatchesThreshold"}, {0.1, 1000, "px"}).value_or(10);
    if (!settings_.pose_from_image && !settings_.features_from_images) return;
    if (!values_.has(radius)) values_.missing(radius, "5 or 10 px");
    if (!values_.has(threshold)) values_.missing(threshold, "the least response of a corner");
    if (!values_.has(distance)) values_.missing(distance, "the least distance between corners, px");
  }

  // Settings written on Windows separate folders with backslashes.
  [[nodiscard]] std::optional<std::string> path_text(const KeyNames& key) {
    std::optional<std::string> given = values_.text(key);
    if (given) std::replace(given->begin(), given->end(), '\\', '/');
    return given;
  }

  // min_u, max_u, min_v, max_v as the release names them, of the first camera; min_u2, .. of further ones.
  Region region(int camera) {
    const auto key = [&](const char* name) {
      return camera == 1 ? KeyNames{name, name + std::string("1")} : KeyNames{name + std::to_string(camera)};
    };
    const NumberRange pixels{0, 1e5, "px"};
    const Region out{integer(key("min_u"), pixels, "least u of the region, px"),
                     integer(key("min_v"), pixels, "least v of the region, px"),
                     integer(key("max_u"), pixels, "largest u of the region, px"),
                     integer(key("max_v"), pixels, "largest v of the region, px")};
    if (values_.finish() && out.empty())
      values_.complain(key("max_u"), "min_u < max_u and min_v < max_v",
                       std::to_string(out.u0) + ".." + std::to_string(out.u1) + ", " + std::to_string(out.v0) + ".." +
                           std::to_string(out.v1));
    return out;
  }

  // As given, relative to the settings' folder; what 2016's code keeps in a folder of its own is looked for there too.
  [[nodiscard]] fs::path input(const std::string& given, const std::vector<const char*>& folders) const {
    const fs::path base = settings_.file.parent_path(), path = given;
    const fs::path as_given = path.is_absolute() ? path : base / path;
    std::error_code error;
    if (guide() || path.is_absolute() || fs::exists(as_given, error)) return as_given.lexically_normal();
    for (const char* folder : folders)
      if (fs::exists(base / folder / path, error)) return (base / folder / path).lexically_normal();
    return as_given.lexically_normal();
  }
  fs::path input_path(const KeyNames& key, const std::string& what, const std::vector<const char*>& folders) {
    const std::optional<std::string> given = path_text(key);
    if (!given && !values_.has(key)) values_.missing(key, what);
    return given ? input(*given, folders) : fs::path{};
  }

  void cameras() {
    const std::vector<const char*> inputs = {"INPUT"}, anywhere = {"INPUT", "RESULTS"}, frames = {"DATA", "INPUT", "RESULTS"};
    const int count = integer(kCameras, {1, kMaxCameras, "cameras"}, "1, 2 or 3");
    for (int i = 1; i <= count; ++i) {
      CameraSettings camera;
      camera.calibration = input_path(numbered("CalibrationFile", i), "the camera's calibration file", inputs);
      camera.reference = input_path(numbered("InputReference", i),
                                    settings_.pose_from_image ? "an image of the dry pattern" : "a pose file", anywhere);
      camera.frames = input_path(numbered("InputDirectory", i),
                                 settings_.features_from_images ? "a folder of images" : "a folder of feature files", frames);
      if (guide()) {
        camera.feature_points = input_path({"InputInitial"}, "the file of the feature points F", inputs);
        camera.position = integer(numbered("Position", i), {1, 4, ""}, "1, 2, 3 or 4 (guide, appendix A)");
      } else {
        if (!patch())
          camera.feature_points = input_path(numbered("InputFeatures", i), "the file of the feature points F", inputs);
        if (settings_.pose_from_image)
          camera.pose_points = input_path(numbered("InputInitial", i), "the file of the reference pattern's points", inputs);
      }
      if (patch()) camera.region = region(i);
      camera.pose_output = path_text(numbered("OutputCameraPose", i)).value_or("");
      if (!patch()) camera.features_output = path_text(numbered("OutputDirectory", i)).value_or("");
      if (settings_.save_pose && settings_.pose_from_image && camera.pose_output.empty())
        values_.missing(numbered("OutputCameraPose", i), "a file name, because poses are to be saved");
      if (!patch() && settings_.save_features && settings_.features_from_images && camera.features_output.empty())
        values_.missing(numbered("OutputDirectory", i), "a folder's name, because features are to be saved");
      settings_.cameras.push_back(camera);
    }
  }

  void outputs() {
    const KeyNames coefficients = {"OutputFileName"};
    const KeyNames errors = {"OutputFileNameErrors", "OutputFileNameResiudals", "OutputFileNameResiduals"};
    settings_.coefficients_output = path_text(coefficients).value_or("");
    if (!values_.has(coefficients)) values_.missing(coefficients, "the file name of the coefficients");
    if (patch()) {
      settings_.save_errors = settings_.save_features = false;  // the release writes neither
      settings_.patch.centres_output = path_text({"OutputFileCenters"}).value_or("");
      return;
    }
    settings_.errors_output = path_text(errors).value_or("");
    if (settings_.save_errors && !values_.has(errors)) values_.missing(errors, "a file name, because errors are to be saved");
  }

  XmlValues values_;
  Settings settings_;
};

}  // namespace

const char* to_string(Dialect dialect) {
  switch (dialect) {
    case Dialect::kGuide: return "user guide";
    case Dialect::k2016: return "2016";
    case Dialect::k2017: return "2017";
  }
  return "unknown";
}

Outcome<Settings> read_settings(const fs::path& file) {
  Outcome<XmlValues> values = XmlValues::load(file);
  if (!values) return values.error();
  return Reader(std::move(values).value(), file).read();
}

}  // namespace srd::host::opensrd
