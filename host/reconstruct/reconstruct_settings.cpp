// SPDX-License-Identifier: Apache-2.0
#include "host/opensrd/reconstruction.hpp"
#include "host/reconstruct/options.hpp"
#include "host/run/report.hpp"

namespace srd::host {

Outcome<void> reconstruct_settings(const ReconstructOptions& options) {
  if (!options.modes.empty() || options.lx || options.ly || !options.guess.empty())
    return Problem{Exit::kUsage,
                   "--modes, --lx, --ly and --guess are for recordings",
                   options.source.string(),
                   "the model in the settings (SurfaceModelParameters, Lx, Ly, InitialGuess)",
                   "",
                   "change the settings"};
  const auto settings = opensrd::read_settings(options.source);
  if (!settings) return settings.error();
  if (options.model && settings->dialect != opensrd::Dialect::k2017)
    return Problem{Exit::kUsage,
                   "--model is for recordings and for settings of the 2017 release",
                   options.source.string(),
                   "the model in the settings (SurfaceModelParameters)",
                   "",
                   "change the settings"};
  if (!options.plates.empty() && (settings->pose_from_image || settings->dialect == opensrd::Dialect::k2017))
    return Problem{Exit::kUsage,
                   "--plate needs poses from files",
                   options.source.string(),
                   "settings of the guide or of 2016 with poses, not reference images",
                   "a pose from an image, which would have been taken through the plates too",
                   "give the poses as files"};
  // Before any work: where results would go, and that nothing is overwritten.
  const bool from_images = settings->features_from_images && !options.features;
  const auto outputs = opensrd::plan_outputs(*settings, options.out, settings->pose_from_image, from_images);
  if (!outputs) return outputs.error();
  if (auto free = opensrd::check_free(*outputs, options.force); !free) return free.error();
  auto prepared = opensrd::prepare(*settings, {options.refractive_index, options.metric, options.features, options.rate_hz,
                                               options.free_index, options.model, options.plates, options.sample_bits});
  if (!prepared) return prepared.error();
  if (prepared->plan.pattern_run && options.loss != dsp::Loss::kNone)
    return Problem{Exit::kUsage,
                   "--loss is for corners",
                   options.source.string(),
                   "settings that fit corners; all pixels of a region, as here, have Huber's loss already",
                   to_string(options.loss),
                   "leave --loss out"};
  prepared->plan.options.loss = options.loss;
  prepared->plan.threads = options.threads;
  const Outcome<RunResult> result = run(prepared->plan, terminal_progress());
  if (!result) return result.error();
  if (auto ready = opensrd::prepare_outputs(*outputs, options.force); !ready) return ready.error();
  if (auto written = opensrd::write_results(*outputs, *settings, *prepared, *result); !written) return written.error();
  return report(prepared->plan, *result, prepared->head, prepared->warnings, options.out);
}

}  // namespace srd::host
