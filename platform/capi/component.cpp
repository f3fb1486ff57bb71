// The component behind the C interface. The handle and its jobs stand at the beginning of the
// caller's memory, the component's tables behind them.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <new>
#include <span>
#include <string_view>

#include "bus/capacities.hpp"
#include "bus/counter_table.hpp"
#include "bus/packet_layout.hpp"
#include "capi/handle.hpp"
#include "capi/parameters.hpp"
#include "capi/polhode.h"
#include "capi/problem.hpp"
#include "os/linux/libraries.hpp"
#include "pipeline/checkpoint.hpp"
#include "pipeline/component.hpp"

namespace {

using polhode::capi::guarded;
using polhode::capi::write_problem;

using Handle = ::polhode_component;

constexpr std::size_t kAlignment = POLHODE_MEMORY_ALIGNMENT;
constexpr std::size_t kHandleOctets = (sizeof(Handle) + kAlignment - 1) / kAlignment * kAlignment;

static_assert(POLHODE_STEP_COMMANDS == polhode::limits::kStepCommands);
static_assert(static_cast<int>(polhode::Mode::kTracking) == POLHODE_TRACKING &&
              static_cast<int>(polhode::Mode::kLost) == POLHODE_LOST &&
              static_cast<int>(polhode::Mode::kCoasting) == POLHODE_COASTING);

polhode_assertion_hook g_assertion_hook = nullptr;  // set once before the first create

void pass_on(const polhode::AssertionReport& report) {
  if (g_assertion_hook != nullptr) {
    g_assertion_hook(report.expression, report.file, report.line, report.value);
  }
}

/// Are the rows of the image whole, and of a depth that there is?
bool is_image(const polhode_input& input) {
  const bool depth = input.pixel_bits == 8 || input.pixel_bits == 16;
  return depth && input.width_px > 0 && input.height_px > 0 &&
         input.stride_octets >= std::int64_t{input.width_px} * (input.pixel_bits / 8);
}

bool is_whole(const polhode_input& input) {
  const bool commands = input.command_count == 0 ||
                        (input.commands != nullptr && input.command_count <= POLHODE_COMMANDS_MAX);
  const bool jobs = input.finished_count == 0 || input.finished != nullptr;
  return commands && jobs && (input.pixels == nullptr || is_image(input));
}

/// The jobs due now are those that were handed in, each once, and all are done. The component
/// would stop the process otherwise.
bool jobs_agree(const Handle& handle, const polhode_input& input) {
  const std::span<polhode_job* const> finished(input.finished, input.finished_count);
  const std::uint32_t step = handle.component->next_step();
  std::size_t due = 0;
  for (const polhode_job& job : handle.jobs) {
    const bool is_due = job.work != nullptr && polhode::due_step(*job.work) <= step;
    const auto handed_in = std::count(finished.begin(), finished.end(), &job);
    if (handed_in != (is_due ? 1 : 0) || (is_due && !job.done)) {
      return false;
    }
    due += is_due ? 1 : 0;
  }
  return due == finished.size();
}

polhode::Frame frame_of(const polhode_input& input) {
  if (input.pixels == nullptr) {
    return {.timestamp_ns = input.timestamp_ns, .image = {}, .readable = false};
  }
  const bool wide = input.pixel_bits == 16;
  return {.timestamp_ns = input.timestamp_ns,
          .image = {.data = input.pixels,
                    .width_px = input.width_px,
                    .height_px = input.height_px,
                    .stride_bytes = static_cast<std::ptrdiff_t>(input.stride_octets),
                    .format = wide ? polhode::PixelFormat::kGray16 : polhode::PixelFormat::kGray8}};
}

polhode::Jobs take_finished(const polhode_input& input) {
  polhode::Jobs jobs;
  for (polhode_job* job : std::span(input.finished, input.finished_count)) {
    (void)jobs.push_back(job->work);
    *job = {};
  }
  return jobs;
}

void copy_motion(const polhode::MotionState& from, polhode_motion* to) {
  *to = {.timestamp_ns = from.timestamp_ns,
         .frame = from.frame,
         .target_frame = from.target_frame,
         .mode = static_cast<std::uint8_t>(from.mode),
         .pose_valid = from.pose_valid,
         .rate_valid = from.rate_valid,
         .velocity_valid = from.velocity_valid,
         .scale_known = from.scale_known,
         .scale_number = static_cast<std::uint8_t>(from.scale_number %
                                                   polhode::bus::motion_layout::kScaleNumbers),
         .spare = {},
         .features = from.features,
         .matches = from.matches,
         .inliers = from.inliers,
         .landmarks = from.landmarks,
         .keyframes = from.keyframes,
         .spare_count = 0,
         .q_CT = {},
         .p_CT = {},
         .v_C = {},
         .w_T_rad_s = {},
         .sigma_att_rad = from.sigma_att_rad,
         .sigma_pos = from.sigma_pos,
         .sigma_vel = from.sigma_vel,
         .sigma_rate_rad_s = from.sigma_rate_rad_s};
  std::copy(from.q_CT.begin(), from.q_CT.end(), to->q_CT);
  std::copy(from.p_CT.begin(), from.p_CT.end(), to->p_CT);
  std::copy(from.v_C.begin(), from.v_C.end(), to->v_C);
  std::copy(from.w_T_rad_s.begin(), from.w_T_rad_s.end(), to->w_T_rad_s);
}

polhode::PointQuestion question_of(const polhode_point_question& from) {
  polhode::PointQuestion to{.timestamp_ns = from.timestamp_ns, .target_frame = from.target_frame};
  std::copy_n(from.p_T, to.p_T.size(), to.p_T.begin());
  std::copy_n(from.normal_T, to.normal_T.size(), to.normal_T.begin());
  return to;
}

void copy_point(const polhode::PointState& from, polhode_point* to) {
  *to = {.timestamp_ns = from.timestamp_ns,
         .from_timestamp_ns = from.from_timestamp_ns,
         .p_C = {},
         .v_C = {},
         .normal_C = {},
         .cov_p = {},
         .cov_v = {},
         .sigma_normal_rad = from.sigma_normal_rad,
         .position_valid = from.position_valid,
         .velocity_valid = from.velocity_valid,
         .normal_valid = from.normal_valid,
         .scale_known = from.scale_known,
         .scale_number = static_cast<std::uint8_t>(from.scale_number %
                                                   polhode::bus::motion_layout::kScaleNumbers),
         .dynamics = from.dynamics,
         .spare = {}};
  std::copy(from.p_C.begin(), from.p_C.end(), to->p_C);
  std::copy(from.v_C.begin(), from.v_C.end(), to->v_C);
  std::copy(from.normal_C.begin(), from.normal_C.end(), to->normal_C);
  std::copy(from.cov_p.begin(), from.cov_p.end(), to->cov_p);
  std::copy(from.cov_v.begin(), from.cov_v.end(), to->cov_v);
}

void copy_jobs(const polhode::Jobs& jobs, Handle* handle, polhode_output* output) {
  for (polhode::Job* work : jobs) {
    auto* free = std::find_if(handle->jobs.begin(), handle->jobs.end(), [](const polhode_job& job) {
      return job.work == nullptr;
    });
    *free = {.work = work, .done = false};
    output->jobs[output->job_count++] = free;
  }
}

polhode_status step_now(const polhode_input& input, Handle* handle, polhode_output* output) {
  std::array<std::span<const std::uint8_t>, POLHODE_COMMANDS_MAX> commands;
  const std::size_t count = input.command_count;
  for (std::size_t i = 0; i < count; ++i) {
    commands[i] = {input.commands[i].data, input.commands[i].data ? input.commands[i].length : 0};
  }
  polhode::StepInput in{.frame = frame_of(input),
                        .finished = take_finished(input),
                        .memory_short = input.memory_short != 0,
                        .commands = std::span(commands).first(count)};
  if (input.q_IC != nullptr) {
    in.q_IC = {input.q_IC[0], input.q_IC[1], input.q_IC[2], input.q_IC[3]};
  }
  const polhode::StepOutput& out = handle->component->step(in);
  *output = {};
  copy_motion(out.motion, &output->motion);
  output->packets = {out.packets.data(), out.packets.size()};
  output->frame_used = out.use == polhode::FrameUse::kUsed ? 1 : 0;
  output->checkpoint_asked = out.checkpoint_asked ? 1 : 0;
  copy_jobs(out.jobs, handle, output);
  return POLHODE_OK;
}

}  // namespace

const char* polhode_version(void) { return polhode::kVersion; }

uint32_t polhode_abi(void) { return POLHODE_ABI; }

const char* polhode_status_name(polhode_status status) {
  constexpr std::array kNames{"ok",
                              "bad argument",
                              "bad parameter",
                              "memory too small or not aligned",
                              "not a checkpoint of this build",
                              "finished jobs are not those due",
                              "failed",
                              "not known",
                              "not a model that this build can take"};
  const bool known = status >= 0 && static_cast<std::size_t>(status) < kNames.size();
  return known ? kNames[static_cast<std::size_t>(status)] : "unknown status";
}

size_t polhode_memory_needed(const polhode_parameters* parameters) {
  return parameters == nullptr ? 0
                               : kHandleOctets + polhode::memory_needed(parameters->values).total;
}

polhode_status polhode_create(void* memory,
                              size_t bytes,
                              const polhode_parameters* parameters,
                              polhode_component** out,
                              char* problem,
                              size_t problem_octets) {
  return guarded([&] {
    if (memory == nullptr || parameters == nullptr || out == nullptr) {
      write_problem("memory, parameters or out: null", problem, problem_octets);
      return polhode_status{POLHODE_BAD_ARGUMENT};
    }
    const bool aligned = reinterpret_cast<std::uintptr_t>(memory) % kAlignment == 0;
    if (bytes < kHandleOctets || !aligned) {
      write_problem("memory: too small, or not aligned to 64", problem, problem_octets);
      return polhode_status{POLHODE_MEMORY_TOO_SMALL};
    }
    polhode::platform::pin_libraries();
    polhode::set_assertion_hook(&pass_on);
    auto* begin = static_cast<std::byte*>(memory);
    auto made = polhode::Component::create({begin + kHandleOctets, bytes - kHandleOctets},
                                           parameters->values);
    if (!made) {
      write_problem(made.error().message, problem, problem_octets);
      const bool small = made.error().code == polhode::ErrorCode::kMemoryTooSmall;
      return polhode_status{small ? POLHODE_MEMORY_TOO_SMALL : POLHODE_BAD_PARAMETER};
    }
    *out = ::new (memory) Handle{.component = made.value(), .jobs = {}, .failed = false};
    return polhode_status{POLHODE_OK};
  });
}

void polhode_destroy(polhode_component* component) {
  if (component != nullptr) {
    (void)guarded([&] {
      polhode::Component::destroy(component->component);
      return polhode_status{POLHODE_OK};
    });
  }
}

polhode_status polhode_step(polhode_component* component,
                            const polhode_input* input,
                            polhode_output* output) {
  if (component == nullptr || input == nullptr || output == nullptr || !is_whole(*input)) {
    return POLHODE_BAD_ARGUMENT;
  }
  if (component->failed) {
    return POLHODE_FAILED;
  }
  if (!jobs_agree(*component, *input)) {
    return POLHODE_JOBS_DIFFER;
  }
  const polhode_status status = guarded([&] { return step_now(*input, component, output); });
  component->failed = status == POLHODE_FAILED;
  return status;
}

polhode_status polhode_predict_point(const polhode_component* component,
                                     const polhode_point_question* question,
                                     polhode_point* out,
                                     char* problem,
                                     size_t problem_octets) {
  if (component == nullptr || question == nullptr || out == nullptr) {
    write_problem("component, question or out: null", problem, problem_octets);
    return POLHODE_BAD_ARGUMENT;
  }
  if (component->failed) {
    return POLHODE_FAILED;
  }
  return guarded([&] {
    polhode::PointState answer;
    const std::string_view why =
        component->component->predict_point(question_of(*question), &answer);
    if (!why.empty()) {
      write_problem(why, problem, problem_octets);
      return polhode_status{POLHODE_NOT_KNOWN};
    }
    copy_point(answer, out);
    return polhode_status{POLHODE_OK};
  });
}

uint32_t polhode_next_step(const polhode_component* component) {
  return component == nullptr ? 0 : component->component->next_step();
}

polhode_status polhode_run_job(polhode_job* job) {
  if (job == nullptr || job->work == nullptr || job->done) {
    return POLHODE_BAD_ARGUMENT;
  }
  const polhode_status status = guarded([&] {
    polhode::run_job(*job->work);
    return polhode_status{POLHODE_OK};
  });
  job->done = status == POLHODE_OK;
  return status;
}

void polhode_skip_job(polhode_job* job) {
  if (job != nullptr && job->work != nullptr && !job->done) {
    polhode::skip_job(*job->work);
    job->done = true;
  }
}

uint32_t polhode_due_step(const polhode_job* job) {
  return job == nullptr || job->work == nullptr ? 0 : polhode::due_step(*job->work);
}

polhode_status polhode_counter(const polhode_component* component,
                               const char* name,
                               uint32_t* value) {
  if (component == nullptr || name == nullptr || value == nullptr) {
    return POLHODE_BAD_ARGUMENT;
  }
  for (const auto& row : polhode::bus::kCounters) {
    if (std::strcmp(row.name, name) == 0) {
      *value = component->component->counters().*row.counted;
      return POLHODE_OK;
    }
  }
  return POLHODE_BAD_ARGUMENT;
}

size_t polhode_checkpoint_octets_max(void) { return polhode::checkpoint_octets_max(); }

polhode_status polhode_save_checkpoint(const polhode_component* component,
                                       uint8_t* out,
                                       size_t bytes,
                                       size_t* written) {
  if (component == nullptr || out == nullptr || written == nullptr) {
    return POLHODE_BAD_ARGUMENT;
  }
  if (component->failed) {
    return POLHODE_FAILED;
  }
  if (bytes < polhode::checkpoint_octets_max()) {
    return POLHODE_MEMORY_TOO_SMALL;
  }
  return guarded([&] {
    *written = polhode::save_checkpoint(*component->component, std::span(out, bytes));
    return polhode_status{POLHODE_OK};
  });
}

polhode_status polhode_restore_checkpoint(polhode_component* component,
                                          const uint8_t* bytes,
                                          size_t length) {
  if (component == nullptr || bytes == nullptr || component->component->next_step() != 0) {
    return POLHODE_BAD_ARGUMENT;
  }
  return guarded([&] {
    const bool taken = polhode::restore_checkpoint(std::span(bytes, length), component->component);
    return polhode_status{taken ? POLHODE_OK : POLHODE_BAD_CHECKPOINT};
  });
}

void polhode_set_assertion_hook(polhode_assertion_hook hook) { g_assertion_hook = hook; }
