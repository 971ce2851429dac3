// SPDX-License-Identifier: Apache-2.0
// Why a device cannot be had, in words.
#include <grp.h>
#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>

#include "drivers/camera/v4l2/v4l2_plan.hpp"

namespace srd {

namespace {

// The group that may open the file; "video" where it cannot be told.
std::string group_of(const std::string& path) {
  struct stat status;
  if (::stat(path.c_str(), &status) == 0 && (status.st_mode & S_IRGRP) != 0 && (status.st_mode & S_IWGRP) != 0)
    if (const group* owner = ::getgrgid(status.st_gid); owner != nullptr && status.st_gid != 0) return owner->gr_name;
  return "video";
}

std::string video_nodes() {
  std::vector<std::string> names;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator("/dev", error))
    if (entry.path().filename().string().starts_with("video")) names.push_back(entry.path().string());
  std::sort(names.begin(), names.end());
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text.empty() ? "no /dev/video at all" : text;
}

}  // namespace

std::string failure_text(const V4l2Failure& failure) {
  if (!failure.any()) return {};
  if (failure.step == V4l2Step::kStalled) return "no frame came";
  std::string text = to_string(failure.step);
  if (failure.error != 0) return text + ": " + std::strerror(failure.error);
  if (failure.step == V4l2Step::kFormat)
    return text + ": it offers " + std::to_string(failure.width) + "x" + std::to_string(failure.height) + " " +
           fourcc_text(failure.code) + " instead";
  return text + ": it does something else than it was asked";
}

Problem problem_of(const V4l2Failure& failure, const std::string& path) {
  Problem problem{Exit::kDevice, "the camera cannot be used", path, "", failure_text(failure), ""};
  switch (failure.error) {
    case ENOENT:
    case ENXIO:
    case ENODEV:
      problem.what = "no such camera";
      problem.expected = "a video capture device";
      if (failure.step == V4l2Step::kOpen) problem.found = video_nodes();
      problem.advice = "check the cable; srd-node --list-cameras shows what is there";
      break;
    case EACCES:
    case EPERM:
      problem.what = "no permission to use the camera";
      problem.expected = "a user in the group '" + group_of(path) + "'";
      problem.advice = "add the user to it (usermod -aG " + group_of(path) + " USER) and log in again";
      break;
    case EBUSY:
      problem.what = "the camera is in use by another program";
      problem.expected = "a device that nobody else streams from";
      problem.advice = "end that program (fuser -v " + path + " names it)";
      break;
    case ENOTTY:
    case EINVAL:
      if (failure.step == V4l2Step::kCapability) {
        problem.what = "not a video device";
        problem.expected = "a V4L2 device such as /dev/video0";
        problem.advice = "srd-node --list-cameras shows what is there";
      }
      break;
    case ENOMEM:
      problem.what = "not enough memory for the camera's buffers";
      problem.advice = "ask for fewer camera.buffers";
      break;
    case EPIPE:
    case ENOLINK: problem.advice = "the parts of the camera are not linked for this format: see media-ctl -p"; break;
    default: break;
  }
  return problem;
}

}  // namespace srd
