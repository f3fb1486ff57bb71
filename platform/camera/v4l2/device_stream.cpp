#include "camera/v4l2/device_stream.hpp"

#include <linux/videodev2.h>
#include <poll.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>

namespace polhode::platform {
namespace {

constexpr std::uint32_t kCapture = V4L2_BUF_TYPE_VIDEO_CAPTURE;

v4l2_format wished_format(std::uint32_t fourcc, int width_px, int height_px) {
  v4l2_format format{};
  format.type = kCapture;
  format.fmt.pix.width = static_cast<std::uint32_t>(width_px);
  format.fmt.pix.height = static_cast<std::uint32_t>(height_px);
  format.fmt.pix.pixelformat = fourcc;
  format.fmt.pix.field = V4L2_FIELD_NONE;
  return format;
}

OfferedFormat offered(const v4l2_format& format) {
  return {.fourcc = format.fmt.pix.pixelformat,
          .width_px = static_cast<int>(format.fmt.pix.width),
          .height_px = static_cast<int>(format.fmt.pix.height),
          .row_octets = format.fmt.pix.bytesperline,
          .image_octets = format.fmt.pix.sizeimage};
}

v4l2_buffer mapped_buffer(std::uint32_t index) {
  v4l2_buffer buffer{};
  buffer.type = kCapture;
  buffer.memory = V4L2_MEMORY_MMAP;
  buffer.index = index;
  return buffer;
}

template <std::size_t kSize>
void copy_text(const std::uint8_t (&from)[kSize], std::array<char, kSize>* to) {
  static_assert(sizeof from == sizeof *to);
  std::memcpy(to->data(), from, kSize);
}

DeviceIdentity identity_of(const v4l2_capability& capability) {
  DeviceIdentity identity;
  copy_text(capability.driver, &identity.driver);
  copy_text(capability.card, &identity.card);
  copy_text(capability.bus_info, &identity.bus);
  return identity;
}

bool is_gone(int error) { return error == -ENODEV || error == -ENXIO; }

}  // namespace

OpenResult DeviceStream::failed(const char* what, int error) {
  std::snprintf(trouble_.data(),
                trouble_.size(),
                "%s: %s: %s",
                path(),
                what,
                ::strerrordesc_np(-error));  // of the C library: no memory of its own
  if (error == -EBUSY) {
    return OpenResult::kBusy;
  }
  return is_gone(error) || error == -ENOENT ? OpenResult::kAbsent : OpenResult::kFailed;
}

OpenResult DeviceStream::open(const char* path) {
  OpenResult result = open_node(path);
  if (result == OpenResult::kStreaming) {
    set_interval();
    controls_.find(calls_, device_);
    result = map_ring();
  }
  if (result == OpenResult::kStreaming) {
    result = start();
  }
  if (result != OpenResult::kStreaming) {
    close();
  }
  return result;
}

OpenResult DeviceStream::check() {
  const OpenResult result = open_node(wish_.path.c_str());
  close();
  return result;
}

OpenResult DeviceStream::open_node(const char* path) {
  close();
  std::snprintf(path_.data(), path_.size(), "%s", path);
  identity_ = {};
  const int device = calls_.open(path);
  if (device < 0) {
    return failed("open", device);
  }
  device_ = device;
  const OpenResult result = check_capabilities();
  return result == OpenResult::kStreaming ? set_format() : result;
}

OpenResult DeviceStream::check_capabilities() {
  v4l2_capability capability{};
  const int answer = calls_.ioctl(device_, VIDIOC_QUERYCAP, &capability);
  if (answer == -ENOTTY || answer == -EINVAL) {
    (void)failed("not a V4L2 device", answer);
    return OpenResult::kUnsuitable;
  }
  if (answer < 0) {
    return failed("QUERYCAP", answer);
  }
  identity_ = identity_of(capability);
  if (only_ && identity_ != *only_) {
    std::snprintf(trouble_.data(), trouble_.size(), "%s is not the one before", path());
    return OpenResult::kOther;
  }
  const std::uint32_t can = (capability.capabilities & V4L2_CAP_DEVICE_CAPS) != 0
                                ? capability.device_caps
                                : capability.capabilities;
  if ((can & V4L2_CAP_VIDEO_CAPTURE) == 0 || (can & V4L2_CAP_STREAMING) == 0) {
    (void)failed("does not capture by streaming", -ENOTSUP);
    return OpenResult::kUnsuitable;
  }
  return OpenResult::kStreaming;
}

OpenResult DeviceStream::set_format() {
  const auto formats = ask_formats(calls_, device_, wish_.format.width_px, wish_.format.height_px);
  const auto choice = choose_format(formats.view(), wish_.format);
  if (!choice) {
    std::snprintf(trouble_.data(),
                  trouble_.size(),
                  "%s: no readable format of %dx%d",
                  path(),
                  wish_.format.width_px,
                  wish_.format.height_px);
    return OpenResult::kUnsuitable;
  }
  v4l2_format format =
      wished_format(formats[*choice].fourcc, wish_.format.width_px, wish_.format.height_px);
  const int answer = calls_.ioctl(device_, VIDIOC_S_FMT, &format);
  if (answer < 0) {
    return failed("S_FMT", answer);
  }
  format_ = offered(format);
  // What was only asked for may differ from what is in force.
  if (!choose_format(std::span(&format_, 1), wish_.format)) {
    return failed("S_FMT gave another format", -EPROTO);
  }
  return OpenResult::kStreaming;
}

/// A device without a settable rate is taken as it runs.
void DeviceStream::set_interval() {
  v4l2_streamparm parameters{};
  parameters.type = kCapture;
  const Interval wished = interval_of(wish_.rate_hz);
  parameters.parm.capture.timeperframe = {wished.numerator, wished.denominator};
  const bool known = calls_.ioctl(device_, VIDIOC_S_PARM, &parameters) >= 0 &&
                     (parameters.parm.capture.capability & V4L2_CAP_TIMEPERFRAME) != 0;
  const v4l2_fract& given = parameters.parm.capture.timeperframe;
  rate_hz_ = known ? platform::rate_hz({given.numerator, given.denominator}) : 0.0;
}

OpenResult DeviceStream::map_ring() {
  v4l2_requestbuffers request{};
  request.count = static_cast<std::uint32_t>(wish_.buffers);
  request.type = kCapture;
  request.memory = V4L2_MEMORY_MMAP;
  if (const int answer = calls_.ioctl(device_, VIDIOC_REQBUFS, &request); answer < 0) {
    return failed("REQBUFS", answer);
  }
  constexpr std::uint32_t kFewest = 2;  // one being looked at, one being filled
  if (request.count < kFewest || request.count > kDeviceBuffers) {
    return failed("REQBUFS gave another number of buffers", -ENOBUFS);
  }
  for (std::uint32_t i = 0; i < request.count; ++i) {
    v4l2_buffer buffer = mapped_buffer(i);
    if (const int answer = calls_.ioctl(device_, VIDIOC_QUERYBUF, &buffer); answer < 0) {
      return failed("QUERYBUF", answer);
    }
    std::uint8_t* block = calls_.map(device_, buffer.length, buffer.m.offset);
    if (block == nullptr) {
      return failed("mmap", -ENOMEM);
    }
    (void)ring_.push_back({.block = block, .octets = buffer.length});
  }
  return OpenResult::kStreaming;
}

OpenResult DeviceStream::start() {
  for (std::uint32_t i = 0; i < ring_.size(); ++i) {
    v4l2_buffer buffer = mapped_buffer(i);
    if (const int answer = calls_.ioctl(device_, VIDIOC_QBUF, &buffer); answer < 0) {
      return failed("QBUF", answer);
    }
  }
  int type = kCapture;
  if (const int answer = calls_.ioctl(device_, VIDIOC_STREAMON, &type); answer < 0) {
    return failed("STREAMON", answer);
  }
  streaming_ = true;
  return OpenResult::kStreaming;
}

void DeviceStream::close() {
  if (!is_open()) {
    return;
  }
  if (streaming_) {
    int type = kCapture;
    (void)calls_.ioctl(device_, VIDIOC_STREAMOFF, &type);  // fails on a device that has gone
    streaming_ = false;
  }
  for (const Mapped& mapped : ring_) {
    calls_.unmap(mapped.block, mapped.octets);
  }
  ring_.clear();
  calls_.close(device_);
  device_ = -1;
}

TakeResult DeviceStream::take(int timeout_ms, TakenBuffer* taken) {
  if (!is_open()) {
    return TakeResult::kGone;
  }
  if (timeout_ms > 0) {
    const int events = calls_.poll(device_, timeout_ms);
    if (events < 0) {
      (void)failed("poll", events);
      return TakeResult::kBroken;
    }
    if (events == 0) {
      return TakeResult::kNothing;
    }
    // An error or a hang-up is told by the next call, too, and there with its reason.
  }
  v4l2_buffer buffer = mapped_buffer(0);
  const int answer = calls_.ioctl(device_, VIDIOC_DQBUF, &buffer);
  if (answer == -EAGAIN) {
    return TakeResult::kNothing;
  }
  if (answer < 0 || buffer.index >= ring_.size()) {
    (void)failed("DQBUF", answer < 0 ? answer : -EPROTO);
    return is_gone(answer) ? TakeResult::kGone : TakeResult::kBroken;
  }
  const bool stamped =
      (buffer.flags & V4L2_BUF_FLAG_TIMESTAMP_MASK) == V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC;
  const bool at_start =
      (buffer.flags & V4L2_BUF_FLAG_TSTAMP_SRC_MASK) == V4L2_BUF_FLAG_TSTAMP_SRC_SOE;
  const Mapped& mapped = ring_[buffer.index];
  const std::int64_t now_ns = calls_.now_ns();
  *taken = {
      .index = buffer.index,
      .sequence = buffer.sequence,
      .stamp_ns = stamped ? std::int64_t{buffer.timestamp.tv_sec} * 1'000'000'000 +
                                std::int64_t{buffer.timestamp.tv_usec} * 1000
                          : now_ns,
      .stamped_at = stamped && at_start ? StampedAt::kStartOfExposure : StampedAt::kEndOfFrame,
      .taken_ns = now_ns,
      .damaged = (buffer.flags & V4L2_BUF_FLAG_ERROR) != 0,
      .octets = {mapped.block, std::min<std::size_t>(buffer.bytesused, mapped.octets)}};
  return TakeResult::kBuffer;
}

bool DeviceStream::give_back(std::uint32_t index) {
  v4l2_buffer buffer = mapped_buffer(index);
  const int answer = is_open() ? calls_.ioctl(device_, VIDIOC_QBUF, &buffer) : -ENODEV;
  if (answer < 0) {
    (void)failed("QBUF", answer);
  }
  return answer >= 0;
}

FixedVector<OfferedFormat, 16> ask_formats(DeviceCalls& calls,
                                           int device,
                                           int width_px,
                                           int height_px) {
  FixedVector<OfferedFormat, 16> answers;
  for (const PixelPacking& packing : pixel_packings()) {
    v4l2_format format = wished_format(packing.fourcc, width_px, height_px);
    if (calls.ioctl(device, VIDIOC_TRY_FMT, &format) >= 0 &&
        format.fmt.pix.pixelformat == packing.fourcc) {
      (void)answers.push_back(offered(format));
    }
  }
  return answers;
}

}  // namespace polhode::platform
