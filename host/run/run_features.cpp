// SPDX-License-Identifier: Apache-2.0
#include "host/run/run_kinds.hpp"

#include <algorithm>
#include <chrono>
#include <optional>

#include "dsp/estimate/estimator/start_history.hpp"
#include "host/run/features.hpp"
#include "host/run/first_surface.hpp"
#include "host/run/identities.hpp"
#include "host/run/ordered_work.hpp"
#include "proto/frame_from_estimate.hpp"

namespace srd::host {

namespace {

using dsp::Observation;
using dsp::Vec2;
using Features = std::vector<Feature>;
using Estimator = dsp::SurfaceEstimator<double>;

Vec2<double> normalised(const Feature& feature, const dsp::CameraModel<double>& camera) {
  return {(feature.u - camera.cx()) / camera.fx(), (feature.v - camera.cy()) / camera.fy()};
}

std::vector<ListedCorner> listed(const Features& features, const dsp::CameraModel<double>& camera) {
  std::vector<ListedCorner> corners;
  for (const Feature& feature : features) corners.push_back({feature.id, normalised(feature, camera)});
  return corners;
}

std::vector<Observation<double>> observe(const Features& features, const RunCamera& camera, bool from_end) {
  std::vector<Observation<double>> corners;
  for (const Feature& feature : features) {
    Observation<double> corner;
    corner.point = point_at(camera, feature.id, from_end);
    corner.normalised = normalised(feature, camera.calibration.camera);
    corner.pixel = camera.calibration.camera.pixel(corner.normalised);
    corners.push_back(corner);
  }
  return corners;
}

}  // namespace

Problem unusable_model(Errc code) {
  return {Exit::kUsage,
          "the model or the optimiser's settings cannot be used",
          "",
          "as many scales as parameters",
          to_string(code),
          ""};
}

Outcome<RunResult> run_features(const RunPlan& plan, const Progress& progress) {
  std::vector<dsp::View<double>> views;
  std::size_t most = 0;
  for (const RunCamera& camera : plan.cameras) {
    views.push_back({camera.calibration.camera, camera.pose});
    most += camera.points.size();
  }
  auto estimator = Estimator::make(plan.model, plan.media, plan.points, plan.options, static_cast<int>(most));
  if (!estimator) return unusable_model(estimator.error());
  auto first = FirstSurface::make(plan, static_cast<int>(most));
  if (!first) return unusable_model(first.error());

  // Each frame starts from the one before, in order; files are read ahead.
  using Lists = std::vector<Outcome<Features>>;  // a list a camera
  const std::size_t total = plan.cameras.front().frames.size();
  OrderedWork<Lists> reading(plan.threads, total, static_cast<std::size_t>(4 * plan.threads), [&](std::size_t i, int) {
    Lists lists;
    for (const RunCamera& camera : plan.cameras)
      lists.push_back(read_features(camera.frames[i], static_cast<int>(camera.points.size())));
    return lists;
  });
  RunResult result;
  dsp::StartHistory<double> history(plan.guess);
  std::vector<std::optional<bool>> from_end(plan.cameras.size());
  for (std::size_t i = 0; i < total; ++i) {
    const auto began = std::chrono::steady_clock::now();
    const Lists lists = reading.take();
    FrameRecord record;
    record.name = plan.cameras.front().frames[i].filename().string();
    record.sequence = plan.sequences[i];
    record.time_ns = plan.times_ns[i];
    std::vector<dsp::CameraObservations<double>> cameras;
    for (std::size_t c = 0; c < plan.cameras.size(); ++c) {
      const RunCamera& camera = plan.cameras[c];
      const Outcome<Features>& features = lists[c];
      if (!features) return features.error();
      if (!from_end[c] && features->size() >= 4) {
        from_end[c] = counts_from_end(listed(*features, views[c].camera), camera, plan.points);
        if (*from_end[c])
          result.warnings.push_back(camera.name + ": the features' ids count from the points' end (" +
                                    camera.frames[i].string() + "); they are read so");
      }
      record.corners.push_back(observe(*features, camera, from_end[c].value_or(false)));
      record.found += static_cast<int>(features->size());
      record.expected += static_cast<int>(camera.points.size());
    }
    for (std::size_t c = 0; c < plan.cameras.size(); ++c) cameras.push_back({&views[c], record.corners[c]});
    const auto known = history.starts(record.time_ns);
    std::vector<dsp::Coefficients<double>> starts(known.begin(), known.end());
    if (history.size() == 0)
      if (const auto surface = first->find(cameras, plan.guess)) starts.insert(starts.begin(), surface->coefficients);
    record.estimate = estimator->estimate(cameras, starts);
    record.status = proto::status_of(record.estimate.stop);
    if (record.has_surface()) history.add(record.time_ns, record.estimate.coefficients);
    record.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
    result.frames.push_back(std::move(record));
    if (progress) progress(i + 1, total);
  }
  return result;
}

}  // namespace srd::host
