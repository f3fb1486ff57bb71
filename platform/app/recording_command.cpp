#include "app/recording_command.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <system_error>

#include "errors.hpp"
#include "recording/export.hpp"

namespace polhode::platform {

void list_recordings(const std::filesystem::path& folder) {
  for (const RecordedRun& run : recorded_runs(folder)) {
    std::uintmax_t bytes = 0;
    for (const auto& file : run.files) {
      std::error_code problem;
      const std::uintmax_t size = std::filesystem::file_size(file, problem);
      bytes += problem ? 0 : size;
    }
    fmt::print("{}  {} files, {:.1f} MB{}\n",
               run.utc_ns,
               run.files.size(),
               1e-6 * static_cast<double>(bytes),
               run.begins ? "" : ", its beginning has been removed");
  }
}

void export_recording(const ExportArguments& arguments) {
  const std::vector<RecordedRun> runs = recorded_runs(arguments.folder);
  const auto wanted = arguments.run_utc_ns == 0
                          ? runs.end() - 1
                          : std::find_if(runs.begin(), runs.end(), [&](const RecordedRun& run) {
                              return run.utc_ns == arguments.run_utc_ns;
                            });
  if (wanted == runs.end()) {
    throw UnusableInput(fmt::format("{}: no run {}; `polhode recording list` shows them",
                                    arguments.folder.string(),
                                    arguments.run_utc_ns));
  }
  const ExportReport report = export_run(*wanted, arguments.out);
  fmt::print("{} frames ({} unreadable), {} commands; the run passed over {}\n",
             report.frames,
             report.unreadable,
             report.commands,
             report.dropped);
  const std::string losses = losses_of(report);
  if (!losses.empty()) {
    fmt::print("not complete: {}\n", losses);
  }
  fmt::print("{}\n",
             replays_to_the_same_bytes(report) ? "a replay gives the bytes of the live run"
                                               : "a replay will differ from the live run");
  if (!report.own_structure_sha256.empty()) {
    fmt::print(
        "the run had a picture of the servicer's own (SHA-256 {}): name it as mask.file of the "
        "configuration\n",
        report.own_structure_sha256);
  }
  fmt::print("polhode replay --config {0}/config.toml --sequence {0}{1} --out DIR\n",
             arguments.out.string(),
             report.has_checkpoint
                 ? fmt::format(" --checkpoint {}/checkpoint", arguments.out.string())
                 : "");
}

}  // namespace polhode::platform
