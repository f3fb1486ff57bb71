// The program: reads the command line, runs one command, turns problems into one line and an exit
// status.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <exception>
#include <map>
#include <string>
#include <system_error>

#include "app/bus_dump.hpp"
#include "app/bus_follow.hpp"
#include "app/camera_command.hpp"
#include "app/check.hpp"
#include "app/model_command.hpp"
#include "app/recording_command.hpp"
#include "app/replay.hpp"
#include "app/run.hpp"
#include "app/sequence_command.hpp"
#include "errors.hpp"
#include "os/linux/assertion.hpp"
#include "os/linux/last_words.hpp"
#include "os/linux/libraries.hpp"
#include "os/linux/standard_files.hpp"
#include "pipeline/component.hpp"
#include "print_stderr.hpp"

namespace {

using polhode::platform::BusDumpArguments;
using polhode::platform::BusFollowArguments;
using polhode::platform::BusSendArguments;
using polhode::platform::CheckArguments;
using polhode::platform::ExportArguments;
using polhode::platform::ModelSaveArguments;
using polhode::platform::ProbeArguments;
using polhode::platform::ReplayArguments;
using polhode::platform::RunArguments;
using polhode::platform::SequenceArguments;

constexpr int kRunFailed = 1;
constexpr int kUnusable = 2;

constexpr const char* kSetHelp =
    "one value on top of the file, dotted key and TOML value, as in scale.known_length_m=0.6";

constexpr const char* kTrapHelp =
    "for tests: exit status 5 when memory or a thread is asked for after the start; ends with the "
    "last frame";

CLI::Option* add_settings(CLI::App& command, std::vector<std::string>& settings) {
  // One value an option: the words that follow are not swallowed.
  return command.add_option("--set", settings, kSetHelp)
      ->type_name("key=value")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll)
      ->allow_extra_args(false);
}

void add_models(CLI::App& command, ReplayArguments& arguments) {
  command.add_option("--model", arguments.model, "of the target, from another pass")
      ->type_name("FILE")
      ->excludes(command.get_option("--checkpoint"));
  command.add_option("--save-model", arguments.save_model, "leave a model for another pass")
      ->type_name("FILE");
}

void add_replay(CLI::App& app, ReplayArguments& arguments) {
  CLI::App* command =
      app.add_subcommand("replay", "estimate motion and shape from a sequence on disk");
  command->add_option("--config", arguments.config, "configuration")
      ->type_name("CONFIG.toml")
      ->required();
  command
      ->add_option(
          "--sequence", arguments.sequence, "folder of an image sequence in the ASL layout")
      ->type_name("SEQ")
      ->required();
  command->add_option("--out", arguments.out, "folder for the results; created if absent")
      ->type_name("DIR")
      ->required();
  command
      ->add_option(
          "--checkpoint", arguments.checkpoint, "state to start from, as exported with a recording")
      ->type_name("FILE");
  command
      ->add_option("--depth-bits",
                   arguments.pixels.depth_bits,
                   "of unshifted levels in 16-bit images: 8, 10, 12, 14 or 16; else by "
                   "sBIT, maxval or the levels themselves")
      ->type_name("BITS")
      ->check(CLI::IsMember({8, 10, 12, 14, 16}));
  command
      ->add_option("--mosaic",
                   arguments.pixels.mosaic,
                   "of a colour sensor, in gray images: level (each pixel becomes the mean "
                   "around it) or keep; else levelled where all images show one")
      ->type_name("level|keep")
      ->transform(CLI::CheckedTransformer(std::map<std::string, polhode::platform::MosaicChoice>{
                                              {"level", polhode::platform::MosaicChoice::kLevel},
                                              {"keep", polhode::platform::MosaicChoice::kKeep}})
                      .description(""));
  command->add_flag(
      "--realtime", arguments.realtime, "hand frames over at the pace of their time stamps");
  command->add_flag(
      "--one-core", arguments.one_core, "run jobs between the steps instead of beside them");
  command
      ->add_option("--job-latency-ms",
                   arguments.job_latency_ms,
                   "for tests: delay each job by a random time up to this")
      ->type_name("MS")
      ->check(CLI::Range(0, 60000));
  command
      ->add_option("--commands",
                   arguments.commands,
                   "time-tagged commands, a line each: TIMESTAMP_NS COMMAND [argument=value]...")
      ->type_name("FILE");
  command->add_flag("--memory-trap", arguments.memory_trap, kTrapHelp);
  command->add_flag(
      "--masks", arguments.masks, "write masks.pgms and mask_tracks.csv, for overlays");
  add_models(*command, arguments);
  add_settings(*command, arguments.settings);
  command->callback([&arguments] { polhode::platform::replay(arguments); });
}

void add_run(CLI::App& app, RunArguments& arguments) {
  CLI::App* command =
      app.add_subcommand("run", "live: camera, bus and recording as the configuration says");
  command->add_option("--config", arguments.config, "configuration")
      ->type_name("CONFIG.toml")
      ->required();
  command->add_flag("--memory-trap", arguments.memory_trap, kTrapHelp);
  add_settings(*command, arguments.settings);
  command->callback([&arguments] { polhode::platform::run_command(arguments); });
}

void add_check(CLI::App& app, CheckArguments& arguments) {
  CLI::App* command =
      app.add_subcommand("check", "validate everything, print the effective table, start nothing");
  auto* config =
      command->add_option("--config", arguments.config, "configuration")->type_name("CONFIG.toml");
  command->add_option("--sequence", arguments.sequence, "an image sequence to validate with it")
      ->type_name("SEQ");
  command->add_flag(
      "--memory", arguments.memory, "print the whole memory plan; refuse one that does not fit");
  auto* settings = add_settings(*command, arguments.settings);
  auto* defaults = command->add_flag(
      "--defaults", arguments.defaults, "print a documented configuration of all defaults instead");
  defaults->excludes(config)->excludes(settings);
  command
      ->add_flag("--bus-parameters",
                 arguments.bus_parameters,
                 "print the parameters that commands may change, as config/bus/parameters.toml")
      ->excludes(config)
      ->excludes(settings)
      ->excludes(defaults);
  command->callback([&arguments] {
    if (arguments.config.empty() && !arguments.defaults && !arguments.bus_parameters) {
      throw CLI::RequiredError("--config");
    }
    polhode::platform::check_configuration(arguments);
  });
}

CLI::Option* add_apid(CLI::App& command, int& apid_first) {
  return command
      .add_option("--apid-first", apid_first, "bus.apid_first of the run, 416 by default")
      ->check(CLI::Range(1, 2031));
}

void add_follow(CLI::App& bus, BusFollowArguments& arguments) {
  CLI::App* follow = bus.add_subcommand("follow", "packets as they come, as a table");
  follow
      ->add_option("ADDRESS",
                   arguments.address,
                   "unix:PATH, udp:PORT, udp:HOST:PORT (bound here), shm:/NAME, file:PATH")
      ->required();
  follow->add_flag("--json", arguments.json, "one JSON object a line instead");
  follow->add_option("--count", arguments.count, "end after so many packets");
  follow->add_option("--timeout", arguments.timeout_s, "end when none comes for so many seconds");
  add_apid(*follow, arguments.apid_first);
  follow->callback([&arguments] { polhode::platform::follow_bus(arguments); });
}

void add_send(CLI::App& bus, BusSendArguments& arguments) {
  CLI::App* send = bus.add_subcommand("send", "send a command");
  send->add_option("ADDRESS", arguments.address, "unix:PATH, udp:PORT, udp:HOST:PORT")->required();
  send->add_option(
          "COMMAND",
          arguments.words,
          "as in: set_range frame_timestamp_ns=5 range_m=12.5; several with + between them")
      ->required();
  add_apid(*send, arguments.apid_first);
  CLI::Option* wait =
      send->add_option("--wait",
                       arguments.wait,
                       "telemetry to read the answers from, as `bus follow` takes it (shm: beside "
                       "other readers); status 1 when a command is refused or not answered");
  send->add_option("--timeout", arguments.timeout_s, "with --wait: seconds for all answers")
      ->check(CLI::Range(0.01, 3600.0))
      ->needs(wait);
  send->add_option(
          "--sequence",
          arguments.sequence,
          "sequence count of the first command, 1 .. 16383; the same command sent again with "
          "its count is answered but not carried out twice; with --wait, only answers to "
          "these counts are taken")
      ->check(CLI::Range(1, 16383));
  CLI::Option* key =
      send->add_option("--key", arguments.key, "sign with the key in this file (commands.key)")
          ->type_name("FILE");
  send->add_option("--number",
                   arguments.number,
                   "number of the signed command; by default the time, UTC in ns")
      ->check(CLI::PositiveNumber)
      ->needs(key);
  send->callback([&arguments] { polhode::platform::send_command(arguments); });
}

struct BusArguments {
  BusDumpArguments dump;
  BusFollowArguments follow;
  BusSendArguments send;
};

void add_bus(CLI::App& app, BusArguments& all) {
  CLI::App* bus = app.add_subcommand("bus", "decode bus packets, send commands");
  bus->require_subcommand(1);
  add_follow(*bus, all.follow);
  add_send(*bus, all.send);
  BusDumpArguments& arguments = all.dump;
  CLI::App* dump = bus->add_subcommand("dump", "the packets of a file, as a table");
  dump->add_option("FILE", arguments.file, "packets, end to end, as in bus.ccsds")->required();
  dump->add_flag("--json", arguments.json, "one JSON object a line instead");
  add_apid(*dump, arguments.apid_first);
  dump->callback([&arguments] { polhode::platform::dump_bus(arguments); });
}

void add_camera(CLI::App& app, ProbeArguments& arguments) {
  CLI::App* camera = app.add_subcommand("camera", "what cameras there are and can do");
  camera->require_subcommand(1);
  camera->add_subcommand("list", "the video devices of this machine")
      ->callback(&polhode::platform::list_cameras);
  CLI::App* probe = camera->add_subcommand("probe", "what a device can do, what would be used");
  probe->add_option("DEVICE", arguments.device, "as in /dev/video0")->required();
  probe->add_option("--width", arguments.width_px, "at this width, pixels");
  probe->add_option("--height", arguments.height_px, "at this height, pixels");
  probe->callback([&arguments] { polhode::platform::probe_camera(arguments); });
}

void add_recording(CLI::App& app, ExportArguments& arguments) {
  CLI::App* recording = app.add_subcommand("recording", "what live runs have recorded");
  recording->require_subcommand(1);
  CLI::App* list = recording->add_subcommand("list", "the runs of a folder");
  list->add_option("FOLDER", arguments.folder, "of recordings")->required();
  list->callback([&arguments] { polhode::platform::list_recordings(arguments.folder); });
  CLI::App* to = recording->add_subcommand("export", "a run as a sequence in the ASL layout");
  to->add_option("FOLDER", arguments.folder, "of recordings")->required();
  to->add_option("--out", arguments.out, "folder of the sequence; not there, or empty")
      ->type_name("SEQ")
      ->required();
  to->add_option("--run", arguments.run_utc_ns, "as listed; else the last one");
  to->callback([&arguments] { polhode::platform::export_recording(arguments); });
}

struct ModelArguments {
  ModelSaveArguments save;
  std::filesystem::path checked;
};

void add_model(CLI::App& app, ModelArguments& arguments) {
  CLI::App* model =
      app.add_subcommand("model", "what is known of a target, to recognise it by in another pass");
  model->require_subcommand(1);
  CLI::App* save = model->add_subcommand("save", "the model of a run's checkpoint");
  save->add_option("CHECKPOINT", arguments.save.checkpoint, "as in run.checkpoint")->required();
  save->add_option("FILE", arguments.save.out, "new, or a model to be replaced")->required();
  save->add_option("--config", arguments.save.config, "of that run, with its [camera]")
      ->type_name("CONFIG.toml")
      ->required();
  add_settings(*save, arguments.save.settings);
  save->callback([&arguments] { polhode::platform::save_model(arguments.save); });
  CLI::App* check = model->add_subcommand("check", "is a model whole, and what is in it");
  check->add_option("FILE", arguments.checked, "as left by replay --save-model or model save")
      ->required();
  check->callback([&arguments] { polhode::platform::check_model(arguments.checked); });
}

void add_sequence(CLI::App& app, SequenceArguments& arguments) {
  CLI::App* command =
      app.add_subcommand("sequence", "what is read of a sequence's tables, as JSON");
  command->add_option("SEQ", arguments.sequence, "folder of an image sequence in the ASL layout")
      ->required();
  command->add_flag("--any-lens", arguments.any_lens, "take `intrinsics: auto`, too, with a guess");
  command->callback([&arguments] { polhode::platform::print_sequence(arguments); });
}

/// The commands that lead the arguments, as far as there are such.
struct NamedCommand {
  std::string path = "polhode";
  std::string unknown;  ///< the word where another command was expected; may be empty
  std::string allowed;  ///< there
};

NamedCommand find_command(const CLI::App& app, int argc, char** argv) {
  NamedCommand named;
  const CLI::App* at = &app;
  for (int i = 1; i < argc && argv[i][0] != '-'; ++i) {
    const auto commands = at->get_subcommands([](const CLI::App*) { return true; });
    const auto found = std::find_if(commands.begin(), commands.end(), [&](const CLI::App* command) {
      return command->get_name() == argv[i];
    });
    if (found == commands.end()) {
      named.unknown = commands.empty() ? "" : argv[i];
      for (const CLI::App* command : commands) {
        named.allowed += (named.allowed.empty() ? "" : ", ") + command->get_name();
      }
      return named;
    }
    at = *found;
    named.path += " " + at->get_name();
  }
  return named;
}

void print_misuse(const NamedCommand& named, const char* problem) {
  if (named.unknown.empty()) {
    polhode::platform::print_stderr(
        "polhode: {} ({} --help shows the usage)\n", problem, named.path);
  } else {
    polhode::platform::print_stderr(
        "{}: unknown command '{}'; allowed are {}\n",
        named.path == "polhode" ? "polhode" : "polhode: " + named.path.substr(8),
        named.unknown,
        named.allowed);
  }
}

int run(int argc, char** argv) {
  CLI::App app{"Motion and shape of a tumbling object from one camera"};
  app.set_version_flag("--version", std::string("polhode ") + polhode::kVersion);
  app.require_subcommand(1);
  ReplayArguments replay;
  RunArguments run;
  CheckArguments check;
  BusArguments bus;
  ProbeArguments probe;
  ExportArguments recording;
  SequenceArguments sequence;
  ModelArguments model;
  add_replay(app, replay);
  add_run(app, run);
  add_check(app, check);
  add_bus(app, bus);
  add_camera(app, probe);
  add_recording(app, recording);
  add_sequence(app, sequence);
  add_model(app, model);
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& request) {  // --help and --version
    return app.exit(request);
  } catch (const CLI::ParseError& problem) {
    print_misuse(find_command(app, argc, argv), polhode::platform::legible(problem.what()).c_str());
    return kUnusable;
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  polhode::platform::prepare_standard_files();
  polhode::platform::print_assertions();
  polhode::platform::pin_libraries();
  try {
    const int status = run(argc, argv);
    if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0) {
      polhode::platform::print_stderr("polhode: standard output: {}\n",
                                      std::generic_category().message(errno));
      return kRunFailed;
    }
    return status;
  } catch (const polhode::platform::UnusableInput& problem) {
    polhode::platform::print_stderr("polhode: {}\n", problem.what());
    return kUnusable;
  } catch (const std::bad_alloc&) {
    polhode::platform::print_last("polhode: the machine gives no more memory\n");
    return kRunFailed;
  } catch (const std::exception& problem) {
    polhode::platform::print_stderr("polhode: {}\n", polhode::platform::legible(problem.what()));
    return kRunFailed;
  }
}
