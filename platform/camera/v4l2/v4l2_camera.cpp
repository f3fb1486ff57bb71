#include "camera/v4l2/v4l2_camera.hpp"

#include <algorithm>
#include <cstdio>

namespace polhode::platform {
namespace {

constexpr std::int64_t kMillisecond_ns = 1'000'000;

bool same(const OfferedFormat& a, const OfferedFormat& b) {
  return a.fourcc == b.fourcc && a.width_px == b.width_px && a.height_px == b.height_px &&
         a.row_bytes == b.row_bytes;
}

const char* name_of(OpenResult result) {
  switch (result) {
    case OpenResult::kBusy:
      return "busy";
    case OpenResult::kUnsuitable:
      return "unsuitable";
    case OpenResult::kOther:
      return "another device";
    case OpenResult::kFailed:
      return "not to be opened";
    default:
      return "away";
  }
}

}  // namespace

V4l2Camera::V4l2Camera(DeviceCalls& calls, const V4l2Options& options)
    : calls_(calls), options_(options), stream_(calls, options.request) {
  set_state("not opened yet", "");
}

void V4l2Camera::set_state(const char* what, std::string_view detail) {
  std::snprintf(state_.data(),
                state_.size(),
                "%s%s%.*s",
                what,
                detail.empty() ? "" : ": ",
                static_cast<int>(detail.size()),
                detail.data());
}

/// Looks at the numbered nodes for the device that streamed before. A camera may have several, of
/// which one captures.
OpenResult V4l2Camera::open_elsewhere() {
  constexpr int kNodes = 64;  // a servicer has fewer; one that is not there costs a microsecond
  for (int number = 0; number < kNodes; ++number) {
    std::array<char, 24> path{};
    std::snprintf(path.data(), path.size(), "/dev/video%d", number);
    if (options_.request.path == path.data()) {
      continue;  // tried already
    }
    const OpenResult result = stream_.open(path.data());
    if (result != OpenResult::kUnsuitable && stream_.identity() == first_identity_) {
      set_state(name_of(result), stream_.trouble());
      return result;
    }
  }
  return OpenResult::kAbsent;
}

OpenResult V4l2Camera::open_wherever_it_is() {
  const OpenResult requested = stream_.open();
  set_state(name_of(requested), stream_.trouble());
  const bool may_be_elsewhere = requested == OpenResult::kAbsent ||
                                requested == OpenResult::kOther ||
                                requested == OpenResult::kUnsuitable;
  if (!converter_ || !may_be_elsewhere) {
    return requested;
  }
  const OpenResult found = open_elsewhere();
  return found == OpenResult::kAbsent ? requested : found;
}

OpenResult V4l2Camera::open() {
  taken_.reset();
  ready_.clear();
  sequence_.restart();
  ++counters_.attempts;
  OpenResult result = open_wherever_it_is();
  if (result == OpenResult::kStreaming && !converter_) {
    first_format_ = stream_.format();
    converter_.emplace(first_format_);
    first_identity_ = stream_.identity();
    stream_.insist_on(first_identity_);
  }
  if (result == OpenResult::kStreaming && !same(stream_.format(), first_format_)) {
    stream_.close();
    set_state("came back with another format", stream_.path());
    result = OpenResult::kUnsuitable;
  }
  if (result != OpenResult::kStreaming) {
    counters_.busy += result == OpenResult::kBusy ? 1 : 0;
    backoff_.failed(calls_.now_ns());
    return result;
  }
  backoff_.succeeded();
  ++counters_.opened;
  waited_ns_ = 0;
  set_state("streaming", options_.request.path == stream_.path() ? "" : stream_.path());
  set_exposure(options_.exposure_ns, options_.gain);
  return result;
}

void V4l2Camera::set_exposure(std::int64_t exposure_ns, double gain) {
  options_.exposure_ns = exposure_ns;  // applied again when the device returns
  options_.gain = gain;
  if (exposure_ns > 0) {
    exposure_before_ns_ = stream_.controls().exposure_ns(exposure_ns);
    exposure_changed_ns_ = calls_.now_ns();
    (void)stream_.set_exposure(exposure_ns);
  }
  if (gain >= 0.0) {
    (void)stream_.set_gain(gain);
  }
}

CameraExposure V4l2Camera::exposure() const {
  const ExposureControls& controls = stream_.controls();
  const ControlRange& range = controls.exposure();
  if (!stream_.is_open() || !range.present || controls.exposure_ns(0) == 0) {
    return {};
  }
  std::int64_t longest_ns = range.high * ExposureControls::kUnit_ns;
  if (stream_.rate_hz() > 0.0) {
    longest_ns = std::min(longest_ns, static_cast<std::int64_t>(1e9 / stream_.rate_hz()));
  }
  return {.settable = true,
          .exposure_ns = controls.exposure_ns(0),
          .exposure_min_ns = std::max<std::int64_t>(range.low, 1) * ExposureControls::kUnit_ns,
          .exposure_max_ns = longest_ns,
          .has_gain = controls.gain().present,
          .gain = controls.gain_fraction()};
}

/// Buffers that were filled before a change still have the exposure from before it.
std::int64_t V4l2Camera::exposure_at(std::int64_t stamp_ns) const {
  return stamp_ns < exposure_changed_ns_ && exposure_before_ns_ > 0
             ? exposure_before_ns_
             : stream_.controls().exposure_ns(options_.exposure_ns);
}

/// When the buffer could have been taken; by its stamp, where that can be of this machine's clock.
std::int64_t V4l2Camera::filled_ns(const TakenBuffer& buffer) const {
  const std::int64_t after_stamp_ns = buffer.stamped_at == StampedAt::kStartOfExposure
                                          ? exposure_at(buffer.stamp_ns) + options_.readout_ns
                                          : 0;
  const std::int64_t waited_ns = buffer.taken_ns - buffer.stamp_ns - after_stamp_ns;
  return waited_ns >= 0 && waited_ns <= options_.silence_max_ns ? buffer.taken_ns - waited_ns
                                                                : buffer.taken_ns;
}

/// Never longer than the time-out, and one attempt at most.
Arrival V4l2Camera::wait_to_open(int timeout_ms) {
  const std::int64_t wait_ns = backoff_.due_ns() - calls_.now_ns();
  if (wait_ns > 0) {
    const std::int64_t wait_ms = (wait_ns + kMillisecond_ns - 1) / kMillisecond_ns;
    calls_.sleep_ms(static_cast<int>(std::min<std::int64_t>(wait_ms, timeout_ms)));
    if (calls_.now_ns() < backoff_.due_ns()) {
      return Arrival::kNothing;
    }
  }
  (void)open();
  return Arrival::kNothing;
}

void V4l2Camera::end_stream(TakeResult why) {
  (why == TakeResult::kGone ? counters_.disconnects : counters_.stream_errors) += 1;
  set_state(why == TakeResult::kGone ? "gone" : "stream failed", stream_.trouble());
  taken_.reset();
  ready_.clear();
  stream_.close();
  backoff_.succeeded();
  backoff_.failed(calls_.now_ns());
}

void V4l2Camera::give_back(const TakenBuffer& buffer) {
  if (!stream_.give_back(buffer.index)) {
    end_stream(TakeResult::kGone);
  }
}

/// Everything that is filled into `ready_`; waits only when nothing is there.
/// @return false when the stream has ended.
bool V4l2Camera::gather(int timeout_ms) {
  for (std::size_t i = 0; i < kDeviceBuffers; ++i) {
    TakenBuffer taken;
    const TakeResult result = stream_.take(ready_.empty() ? timeout_ms : 0, &taken);
    if (result == TakeResult::kNothing) {
      return true;
    }
    if (result != TakeResult::kBuffer) {
      // Frames that came whole before the end are lost with their buffers.
      counters_.frames_missing += static_cast<std::uint32_t>(ready_.size());
      end_stream(result);
      return false;
    }
    waited_ns_ = 0;
    counters_.frames_missing += sequence_.missing_before(taken.sequence);
    (void)ready_.push_back(taken);  // has room for all buffers that there are
  }
  return true;
}

void V4l2Camera::pass_over_late() {
  while (stream_.is_open() && static_cast<int>(ready_.size()) > 1 + options_.backlog_frames_max) {
    const TakenBuffer oldest = ready_[0];
    ready_.erase(0);
    ++counters_.frames_late;
    give_back(oldest);
  }
}

Arrival V4l2Camera::hand_out(Frame* frame) {
  const TakenBuffer buffer = ready_[0];
  ready_.erase(0);
  const std::int64_t timestamp_ns =
      options_.clock_offset_ns + mid_exposure_ns(buffer.stamp_ns,
                                                 {.stamped_at = buffer.stamped_at,
                                                  .exposure_ns = exposure_at(buffer.stamp_ns),
                                                  .readout_ns = options_.readout_ns});
  if (timestamp_ns <= last_timestamp_ns_ && !outvotes(timestamp_ns, &earlier_times_)) {
    ++counters_.frames_out_of_time;
    give_back(buffer);
    return Arrival::kNothing;
  }
  earlier_times_ = {};
  last_timestamp_ns_ = timestamp_ns;
  available_ns_ = filled_ns(buffer);
  *frame = {.timestamp_ns = timestamp_ns, .image = {}, .readable = false};
  frame->readable = !buffer.damaged && converter_->convert(buffer.bytes, &frame->image);
  if (!frame->readable) {
    frame->image = {};
    ++counters_.frames_damaged;
  }
  ++counters_.frames;
  taken_ = buffer;
  return Arrival::kFrame;
}

Arrival V4l2Camera::next(int timeout_ms, Frame* frame) {
  if (taken_) {
    const TakenBuffer seen = *taken_;
    taken_.reset();
    give_back(seen);
  }
  if (!stream_.is_open()) {
    return wait_to_open(timeout_ms);
  }
  const std::int64_t before_ns = calls_.now_ns();
  if (!gather(timeout_ms)) {
    return Arrival::kNothing;
  }
  pass_over_late();
  if (!stream_.is_open() || ready_.empty()) {
    ++counters_.timeouts;
    waited_ns_ += calls_.now_ns() - before_ns;
    if (stream_.is_open() && waited_ns_ > options_.silence_max_ns) {
      end_stream(TakeResult::kBroken);
      set_state("silent", stream_.path());
    }
    return Arrival::kNothing;
  }
  return hand_out(frame);
}

}  // namespace polhode::platform
