#include "camera/v4l2/device_stream.hpp"

#include <linux/videodev2.h>
#include <poll.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>

namespace polhode::platform {
namespace {

bool has_planes(std::uint32_t type) { return type == V4L2_BUF_TYPE_VIDEO_CAPTURE_MPLANE; }

v4l2_format requested_format(std::uint32_t type,
                             std::uint32_t fourcc,
                             int width_px,
                             int height_px) {
  v4l2_format format{};
  format.type = type;
  if (has_planes(type)) {
    format.fmt.pix_mp.width = static_cast<std::uint32_t>(width_px);
    format.fmt.pix_mp.height = static_cast<std::uint32_t>(height_px);
    format.fmt.pix_mp.pixelformat = fourcc;
    format.fmt.pix_mp.field = V4L2_FIELD_NONE;
    return format;
  }
  format.fmt.pix.width = static_cast<std::uint32_t>(width_px);
  format.fmt.pix.height = static_cast<std::uint32_t>(height_px);
  format.fmt.pix.pixelformat = fourcc;
  format.fmt.pix.field = V4L2_FIELD_NONE;
  return format;
}

/// Of several planes the first has the luminance.
OfferedFormat offered(const v4l2_format& format) {
  if (has_planes(format.type)) {
    const v4l2_pix_format_mplane& planes = format.fmt.pix_mp;
    return {.fourcc = planes.pixelformat,
            .width_px = static_cast<int>(planes.width),
            .height_px = static_cast<int>(planes.height),
            .row_bytes = planes.plane_fmt[0].bytesperline,
            .image_bytes = planes.plane_fmt[0].sizeimage,
            .field = planes.field};
  }
  return {.fourcc = format.fmt.pix.pixelformat,
          .width_px = static_cast<int>(format.fmt.pix.width),
          .height_px = static_cast<int>(format.fmt.pix.height),
          .row_bytes = format.fmt.pix.bytesperline,
          .image_bytes = format.fmt.pix.sizeimage,
          .field = format.fmt.pix.field};
}

/// A buffer as it is named in a call, with its planes where the device has such.
struct NamedBuffer {
  NamedBuffer(std::uint32_t type, std::uint32_t index, std::uint32_t plane_count)
      : in_planes(has_planes(type)) {
    buffer.type = type;
    buffer.memory = V4L2_MEMORY_MMAP;
    buffer.index = index;
    if (in_planes) {
      buffer.m.planes = planes.data();
      buffer.length = plane_count;
    }
  }
  NamedBuffer(const NamedBuffer&) = delete;
  NamedBuffer& operator=(const NamedBuffer&) = delete;

  [[nodiscard]] std::uint32_t length() const {
    return in_planes ? planes[0].length : buffer.length;
  }
  [[nodiscard]] std::uint32_t map_offset() const {
    return in_planes ? planes[0].m.mem_offset : buffer.m.offset;
  }
  /// Where the content begins, and ends.
  [[nodiscard]] std::uint32_t begin() const { return in_planes ? planes[0].data_offset : 0; }
  [[nodiscard]] std::uint32_t end() const {
    return in_planes ? planes[0].bytesused : buffer.bytesused;
  }

  bool in_planes;
  v4l2_buffer buffer{};
  std::array<v4l2_plane, VIDEO_MAX_PLANES> planes{};
};

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
  const OpenResult result = open_node(request_.path.c_str());
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
  type_ = capture_type(capability);
  if (type_ == 0) {
    (void)failed("does not capture by streaming", -ENOTSUP);
    return OpenResult::kUnsuitable;
  }
  return OpenResult::kStreaming;
}

OpenResult DeviceStream::set_format() {
  const auto formats =
      ask_formats(calls_, device_, type_, request_.format.width_px, request_.format.height_px);
  const auto choice = choose_format(formats.view(), request_.format);
  if (!choice) {
    const auto field = std::find_if(formats.begin(), formats.end(), [&](const OfferedFormat& f) {
      return !interlacing(f.field).empty() &&
             (request_.format.fourcc == 0 || f.fourcc == request_.format.fourcc);
    });
    if (field != formats.end()) {
      std::snprintf(trouble_.data(),
                    trouble_.size(),
                    "%s: gives %s; allowed are progressive frames, all rows of one moment",
                    path(),
                    interlacing(field->field).data());
      return OpenResult::kUnsuitable;
    }
    std::snprintf(trouble_.data(),
                  trouble_.size(),
                  "%s: no readable format of %dx%d",
                  path(),
                  request_.format.width_px,
                  request_.format.height_px);
    return OpenResult::kUnsuitable;
  }
  v4l2_format format = requested_format(
      type_, formats[*choice].fourcc, request_.format.width_px, request_.format.height_px);
  const int answer = calls_.ioctl(device_, VIDIOC_S_FMT, &format);
  if (answer < 0) {
    return failed("S_FMT", answer);
  }
  format_ = offered(format);
  planes_ = has_planes(type_) ? format.fmt.pix_mp.num_planes : 1;
  if (planes_ < 1 || planes_ > VIDEO_MAX_PLANES) {
    return failed("S_FMT gave no planes", -EPROTO);
  }
  // The requested format may differ from the one in force.
  if (!choose_format(std::span(&format_, 1), request_.format)) {
    return failed("S_FMT gave another format", -EPROTO);
  }
  return OpenResult::kStreaming;
}

/// A device without a settable rate is taken as it runs.
void DeviceStream::set_interval() {
  v4l2_streamparm parameters{};
  parameters.type = type_;
  const Interval requested = interval_of(request_.rate_hz);
  parameters.parm.capture.timeperframe = {requested.numerator, requested.denominator};
  const bool known = calls_.ioctl(device_, VIDIOC_S_PARM, &parameters) >= 0 &&
                     (parameters.parm.capture.capability & V4L2_CAP_TIMEPERFRAME) != 0;
  const v4l2_fract& given = parameters.parm.capture.timeperframe;
  rate_hz_ = known ? platform::rate_hz({given.numerator, given.denominator}) : 0.0;
}

OpenResult DeviceStream::map_ring() {
  v4l2_requestbuffers request{};
  request.count = static_cast<std::uint32_t>(request_.buffers);
  request.type = type_;
  request.memory = V4L2_MEMORY_MMAP;
  if (const int answer = calls_.ioctl(device_, VIDIOC_REQBUFS, &request); answer < 0) {
    return failed("REQBUFS", answer);
  }
  constexpr std::uint32_t kFewest = 2;  // one being looked at, one being filled
  if (request.count < kFewest || request.count > kDeviceBuffers) {
    return failed("REQBUFS gave another number of buffers", -ENOBUFS);
  }
  for (std::uint32_t i = 0; i < request.count; ++i) {
    NamedBuffer named(type_, i, planes_);
    if (const int answer = calls_.ioctl(device_, VIDIOC_QUERYBUF, &named.buffer); answer < 0) {
      return failed("QUERYBUF", answer);
    }
    std::uint8_t* block = calls_.map(device_, named.length(), named.map_offset());
    if (block == nullptr) {
      return failed("mmap", -ENOMEM);
    }
    (void)ring_.push_back({.block = block, .bytes = named.length()});
  }
  return OpenResult::kStreaming;
}

OpenResult DeviceStream::start() {
  for (std::uint32_t i = 0; i < ring_.size(); ++i) {
    NamedBuffer named(type_, i, planes_);
    if (const int answer = calls_.ioctl(device_, VIDIOC_QBUF, &named.buffer); answer < 0) {
      return failed("QBUF", answer);
    }
  }
  std::uint32_t type = type_;
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
    std::uint32_t type = type_;
    (void)calls_.ioctl(device_, VIDIOC_STREAMOFF, &type);  // fails on a device that has gone
    streaming_ = false;
  }
  for (const Mapped& mapped : ring_) {
    calls_.unmap(mapped.block, mapped.bytes);
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
    // An error or a hang-up is reported by the next call, too, and there with its reason.
  }
  NamedBuffer named(type_, 0, planes_);
  const v4l2_buffer& buffer = named.buffer;
  const int answer = calls_.ioctl(device_, VIDIOC_DQBUF, &named.buffer);
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
  const std::size_t end = std::min<std::size_t>(named.end(), mapped.bytes);
  const std::size_t begin = std::min<std::size_t>(named.begin(), end);
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
      .bytes = {mapped.block + begin, end - begin}};
  return TakeResult::kBuffer;
}

bool DeviceStream::give_back(std::uint32_t index) {
  NamedBuffer named(type_, index, planes_);
  const int answer = is_open() ? calls_.ioctl(device_, VIDIOC_QBUF, &named.buffer) : -ENODEV;
  if (answer < 0) {
    (void)failed("QBUF", answer);
  }
  return answer >= 0;
}

std::uint32_t capture_type(const v4l2_capability& capability) {
  const std::uint32_t can = (capability.capabilities & V4L2_CAP_DEVICE_CAPS) != 0
                                ? capability.device_caps
                                : capability.capabilities;
  if ((can & V4L2_CAP_STREAMING) == 0) {
    return 0;
  }
  if ((can & V4L2_CAP_VIDEO_CAPTURE) != 0) {
    return V4L2_BUF_TYPE_VIDEO_CAPTURE;
  }
  return (can & V4L2_CAP_VIDEO_CAPTURE_MPLANE) != 0 ? V4L2_BUF_TYPE_VIDEO_CAPTURE_MPLANE : 0;
}

FixedVector<OfferedFormat, kAskedFormats> ask_formats(
    DeviceCalls& calls, int device, std::uint32_t type, int width_px, int height_px) {
  FixedVector<OfferedFormat, kAskedFormats> answers;
  for (const PixelPacking& packing : pixel_packings()) {
    v4l2_format format = requested_format(type, packing.fourcc, width_px, height_px);
    if (calls.ioctl(device, VIDIOC_TRY_FMT, &format) >= 0 &&
        offered(format).fourcc == packing.fourcc) {
      (void)answers.push_back(offered(format));
    }
  }
  return answers;
}

}  // namespace polhode::platform
