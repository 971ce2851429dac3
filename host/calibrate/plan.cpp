// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <charconv>
#include <map>

#include "drivers/recording/natural_order.hpp"
#include "drivers/support/text_file.hpp"
#include "host/calibrate/options.hpp"
#include "host/opensrd/xml_values.hpp"

namespace srd::host {

namespace {

namespace fs = std::filesystem;

constexpr int kMinCorners = 4, kMaxCornersAlong = 200;
constexpr double kMaxSquareMm = 1e4;
constexpr const char* kBoardForm = "two whole numbers from 4 to 200, inner corners along and across, as 17x7";

Outcome<bundle::BoardShape> parse_board(const std::string& text) {
  const auto wrong = [&] {
    return Problem{Exit::kUsage, "is no size of a board", "--board", kBoardForm, "'" + text + "'", ""};
  };
  const std::size_t cross = text.find_first_of("xX");
  if (cross == std::string::npos) return wrong();
  const auto along = parse_number<int>(std::string_view(text).substr(0, cross));
  const auto across = parse_number<int>(std::string_view(text).substr(cross + 1));
  if (!along || !across) return wrong();
  for (const int side : {*along, *across})
    if (side < kMinCorners || side > kMaxCornersAlong) return wrong();
  return bundle::BoardShape{*across, *along, 0};
}

Outcome<std::vector<fs::path>> images_of(const fs::path& folder, std::vector<std::string>& warnings) {
  std::error_code error;
  std::vector<std::string> names;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error))
    if (is_image_name(entry->path())) names.push_back(entry->path().filename().string());
  if (error || names.empty())
    return Problem{Exit::kInput,
                   "holds no image",
                   folder.string(),
                   "images of a checkerboard (PNG, PGM, BMP, TIFF, JPEG)",
                   error ? error.message() : "no file with such an ending",
                   ""};
  if (const std::string doubt = sort_naturally(names); !doubt.empty()) warnings.push_back(folder.string() + ": " + doubt);
  std::vector<fs::path> files;
  for (const std::string& name : names) files.push_back(folder / name);
  return files;
}

// OpenSRD's settings of a calibration: the user guide's dialect of all its releases.
Outcome<void> read_settings(const fs::path& file, CalibratePlan& plan) {
  auto values = opensrd::XmlValues::load(file);
  if (!values) return values.error();
  const auto required = [&](const opensrd::KeyNames& key, const char* what) {
    if (!values->has(key)) values->missing(key, what);
  };
  if (!values->has({"Write_outputFileName"}) && values->has({"OutputFileName"}))
    return Problem{Exit::kUsage,           "are settings of a reconstruction", file.string(), "settings of a calibration",
                   "key 'OutputFileName'", "srd reconstruct reads them"};
  const NumberRange corners{kMinCorners, kMaxCornersAlong, "inner corners"};
  plan.board.rows = values->integer({"BoardSize_Width"}, corners).value_or(0);
  plan.board.columns = values->integer({"BoardSize_Height"}, corners).value_or(0);
  plan.board.square_mm = values->number({"Square_Size"}, {1e-3, kMaxSquareMm, "mm"}).value_or(0);
  required({"BoardSize_Width"}, "rows of inner corners");
  required({"BoardSize_Height"}, "columns of inner corners");
  required({"Square_Size"}, "side of a square, mm");
  const auto most = values->integer({"nframes"}, {1, 1e6, "images"});
  const auto folder = values->text({"InputDirectory"});
  required({"InputDirectory"}, "folder of the images, in double quotes");
  if (values->has({"Write_outputFileName"}))
    if (const auto name = values->text({"Write_outputFileName"})) {
      plan.calibration_name = fs::path(*name).filename().string();
      if (plan.calibration_name.empty()) values->complain({"Write_outputFileName"}, "the name of a file", *name);
    }
  if (const auto adapt = values->flag({"adaptImage"}); adapt && *adapt)
    plan.warnings.push_back(values->where({"adaptImage"}) +
                            ": key 'adaptImage' has no effect: corners are found in the images as they are");
  // Per-view errors and undistorted images are always written, and no window is opened.
  for (const char* key : {"Showcalib", "writePerview", "Show_UndistortedImage"}) values->know({key});
  if (auto good = values->finish(); !good) return good.error();
  for (const std::string& key : values->unknown())
    plan.warnings.push_back(values->where({key}) + ": unknown key '" + key + "' is ignored, as OpenSRD does");

  std::string given = *folder;
  std::error_code error;
  if (!fs::exists(file.parent_path() / given, error) && !fs::exists(given, error))
    std::replace(given.begin(), given.end(), '\\', '/');  // written on Windows
  const fs::path beside = file.parent_path() / given;
  const fs::path images = fs::is_directory(beside, error) ? beside : fs::path(given);
  if (!fs::is_directory(images, error))
    return Problem{Exit::kInput,
                   "no such folder",
                   values->where({"InputDirectory"}),
                   "the folder of the calibration's images",
                   beside.string(),
                   "give a folder that is there, or the images themselves"};
  auto files = images_of(images, plan.warnings);
  if (!files) return files.error();
  if (most && static_cast<std::size_t>(*most) < files->size()) {
    plan.warnings.push_back(values->where({"nframes"}) + ": the first " + std::to_string(*most) + " of " +
                            std::to_string(files->size()) + " images are used");
    files->resize(static_cast<std::size_t>(*most));
  }
  plan.images = std::move(*files);
  return {};
}

Outcome<void> each_once(const std::vector<fs::path>& images) {
  std::map<std::string, fs::path> seen;
  for (const fs::path& image : images) {
    std::error_code error;
    const fs::path real = fs::weakly_canonical(image, error);
    const auto [earlier, is_new] = seen.emplace(error ? image.string() : real.string(), image);
    if (!is_new)
      return Problem{Exit::kUsage,
                     "is given twice",
                     image.string(),
                     "every image once: a view that counts twice makes errors too small",
                     earlier->second.string(),
                     "leave one out"};
  }
  return {};
}

}  // namespace

Outcome<CalibratePlan> plan_calibration(const CalibrateOptions& options) {
  CalibratePlan plan;
  plan.camera = options.camera;
  plan.search = options.search;
  for (const fs::path& source : options.sources) {
    std::error_code error;
    if (!fs::exists(source, error))
      return Problem{
          Exit::kInput, "no such file or folder", source.string(), "an image, a folder of images, or an OpenSRD settings file",
          "",           "check the path"};
    if (source.extension() == ".xml") {
      if (options.sources.size() > 1)
        return Problem{
            Exit::kUsage, "a settings file stands alone", source.string(), "images, or one settings file", "both", ""};
      if (auto read = read_settings(source, plan); !read) return read.error();
    } else if (fs::is_directory(source, error)) {
      const auto files = images_of(source, plan.warnings);
      if (!files) return files.error();
      plan.images.insert(plan.images.end(), files->begin(), files->end());
    } else {
      plan.images.push_back(source);
    }
  }
  if (!options.board.empty()) {
    const auto board = parse_board(options.board);
    if (!board) return board.error();
    plan.board.rows = board->rows;
    plan.board.columns = board->columns;
  }
  if (options.square) plan.board.square_mm = *options.square;
  if (plan.board.rows == 0)
    return Problem{Exit::kUsage, "the board's size is missing",
                   "--board",    kBoardForm,
                   "",           "count the inner corners, where four squares meet"};
  if (!(plan.board.square_mm > 0))
    return Problem{Exit::kUsage,
                   "the side of a square is missing",
                   "--square-mm",
                   "mm, measured over many squares",
                   "",
                   "measure ten squares and divide by ten: the pose's lengths are as true as this number"};
  if (auto once = each_once(plan.images); !once) return once.error();
  return plan;
}

}  // namespace srd::host
