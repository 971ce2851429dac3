#include "host/opensrd/reconstruction.hpp"
#include "host/reconstruct/options.hpp"
#include "host/reconstruct/report.hpp"

namespace srd::host {

Outcome<void> reconstruct_settings(const ReconstructOptions& options) {
  if (options.model || !options.modes.empty() || options.lx || options.ly || !options.guess.empty())
    return Problem{Exit::kUsage, "--model, --modes, --lx, --ly and --guess are for recordings", options.source.string(),
                   "the model in the settings (SurfaceModelParameters, Lx, Ly, InitialGuess)", "", "change the settings"};
  const auto settings = opensrd::read_settings(options.source);
  if (!settings) return settings.error();
  // Before any work: where results would go, and that nothing is overwritten.
  const bool from_images = settings->features_from_images && !options.features;
  const auto outputs = opensrd::plan_outputs(*settings, options.out, settings->pose_from_image, from_images);
  if (!outputs) return outputs.error();
  if (auto free = opensrd::check_free(*outputs, options.force); !free) return free.error();
  const auto prepared =
      opensrd::prepare(*settings, {options.refractive_index, options.metric, options.features,
                                                     options.rate_hz, options.free_index});
  if (!prepared) return prepared.error();
  const Outcome<RunResult> result = run(prepared->plan, terminal_progress());
  if (!result) return result.error();
  if (auto ready = opensrd::prepare_outputs(*outputs, options.force); !ready) return ready.error();
  if (auto written = opensrd::write_results(*outputs, *settings, *prepared, *result); !written) return written.error();
  return report(prepared->plan, *result, prepared->head, prepared->warnings, options.out);
}

}  // namespace srd::host
