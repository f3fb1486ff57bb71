// A capture device in memory with videobuf2's rules of buffer ownership, and every fault on
// request.
#pragma once

#include <linux/videodev2.h>
#include <poll.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <deque>
#include <map>
#include <string>
#include <vector>

#include "camera/v4l2/device_calls.hpp"

namespace polhode::platform {

class FakeDevice final : public DeviceCalls {
 public:
  static constexpr int kDescriptor = 7;
  static constexpr int kStranger = 8;

  // What it is.
  std::uint32_t capabilities = V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_STREAMING;
  std::vector<std::uint32_t> formats{V4L2_PIX_FMT_GREY};
  std::uint32_t width = 64;
  std::uint32_t height = 48;
  std::uint32_t row_padding = 0;
  std::uint32_t planes = 0;  ///< of its buffers; 0: none, as most devices
  std::uint32_t field = V4L2_FIELD_NONE;
  std::uint32_t bytes_before = 0;   ///< of a plane's content
  std::uint32_t buffers_given = 0;  ///< 0: as many as are asked for
  std::uint32_t stamp_flags = V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC | V4L2_BUF_FLAG_TSTAMP_SRC_EOF;
  bool has_exposure = true;
  std::string node =
      "/dev/video9";  ///< where it is; the others are not there, but for the stranger's
  std::string card = "fake";
  std::string stranger;  ///< node of another camera like it; empty: there is none

  // What goes wrong: the answer to a request from now on, -errno.
  std::map<unsigned long, int> answers;
  int open_answer = kDescriptor;
  bool map_fails = false;
  std::uint32_t lie_about_index = 0;  ///< added to the number of each filled buffer
  bool gone = false;                  ///< unplugged: every call fails with ENODEV
  bool failed = false;  ///< fatal streaming error: poll shows it, taking a buffer is EIO

  // What happened.
  std::int64_t time_ns = 1'000'000'000;
  int open_count = 0;
  int open_now = 0;
  std::size_t mapped_now = 0;
  bool streaming = false;
  std::map<std::uint32_t, std::int32_t> controls;
  std::vector<unsigned long> strangers_requests;

  /// The sensor takes a frame into the next queued buffer; without one, the frame is lost.
  bool take_frame(std::uint8_t level, std::uint32_t flags = 0, std::uint32_t bytes_short = 0) {
    const std::uint32_t number = sequence_++;
    if (!streaming || queued_.empty()) {
      return false;
    }
    v4l2_buffer buffer{};
    buffer.index = queued_.front();
    queued_.pop_front();
    std::memset(memory_[buffer.index].data(), level, memory_[buffer.index].size());
    buffer.sequence = number;
    buffer.bytesused = static_cast<std::uint32_t>(memory_[buffer.index].size()) - bytes_short;
    buffer.flags = stamp_flags | flags;
    buffer.timestamp.tv_sec = time_ns / 1'000'000'000;
    buffer.timestamp.tv_usec = time_ns % 1'000'000'000 / 1000;
    filled_.push_back(buffer);
    return true;
  }
  void lose_frames(std::uint32_t count) { sequence_ += count; }
  [[nodiscard]] std::size_t queued() const { return queued_.size(); }

  int open(const char* path) override {
    if (stranger == path) {
      ++open_now;
      return kStranger;
    }
    if (node != path) {
      return -ENOENT;
    }
    ++open_count;
    if (open_answer < 0) {
      return open_answer;
    }
    ++open_now;
    gone = false;
    failed = false;
    return kDescriptor;
  }
  void close(int device) override {
    --open_now;
    if (device == kStranger) {
      return;
    }
    streaming = false;
    queued_.clear();
    filled_.clear();
  }
  int ioctl(int device, unsigned long request, void* argument) override {
    if (device == kStranger) {
      strangers_requests.push_back(request);
      return introduce("stranger", argument);  // must not be asked for more than who it is
    }
    if (gone) {
      return -ENODEV;
    }
    if (const auto found = answers.find(request); found != answers.end()) {
      return found->second;
    }
    return answer(request, argument);
  }
  std::uint8_t* map(int /*device*/, std::size_t /*bytes*/, std::int64_t offset) override {
    if (map_fails) {
      return nullptr;
    }
    ++mapped_now;
    return memory_[static_cast<std::size_t>(offset)].data();
  }
  void unmap(std::uint8_t* /*block*/, std::size_t /*bytes*/) override { --mapped_now; }
  int poll(int /*device*/, int timeout_ms) override {
    if (gone || failed) {
      return gone ? POLLERR | POLLHUP : POLLERR;
    }
    if (filled_.empty()) {
      time_ns += std::int64_t{timeout_ms} * 1'000'000;
      return 0;
    }
    return POLLIN;
  }
  std::int64_t now_ns() override { return time_ns; }
  void sleep_ms(int duration_ms) override { time_ns += std::int64_t{duration_ms} * 1'000'000; }

 private:
  int introduce(const std::string& name, void* argument) const {
    auto* capability = static_cast<v4l2_capability*>(argument);
    capability->capabilities = capabilities;
    std::strncpy(
        reinterpret_cast<char*>(capability->card), name.c_str(), sizeof capability->card - 1);
    return 0;
  }

  int answer(unsigned long request, void* argument) {
    switch (request) {
      case VIDIOC_QUERYCAP:
        return introduce(card, argument);
      case VIDIOC_TRY_FMT:
      case VIDIOC_S_FMT:
        return set_format(static_cast<v4l2_format*>(argument));
      case VIDIOC_S_PARM:
        static_cast<v4l2_streamparm*>(argument)->parm.capture.capability = V4L2_CAP_TIMEPERFRAME;
        return 0;
      case VIDIOC_QUERYCTRL:
        return query_control(static_cast<v4l2_queryctrl*>(argument));
      case VIDIOC_S_CTRL: {
        const auto* control = static_cast<v4l2_control*>(argument);
        controls[control->id] = control->value;
        return 0;
      }
      case VIDIOC_G_CTRL: {
        auto* control = static_cast<v4l2_control*>(argument);
        control->value = controls[control->id];
        return 0;
      }
      default:
        return stream_answer(request, argument);
    }
  }

  int stream_answer(unsigned long request, void* argument) {
    auto* buffer = static_cast<v4l2_buffer*>(argument);
    switch (request) {
      case VIDIOC_REQBUFS: {
        auto* asked = static_cast<v4l2_requestbuffers*>(argument);
        asked->count = buffers_given > 0 ? buffers_given : asked->count;
        memory_.assign(asked->count, std::vector<std::uint8_t>(image_bytes()));
        return 0;
      }
      case VIDIOC_QUERYBUF:
        if (!names_planes(*buffer)) {
          return -EINVAL;
        }
        (planes > 0 ? buffer->m.planes[0].length : buffer->length) = image_bytes();
        (planes > 0 ? buffer->m.planes[0].m.mem_offset : buffer->m.offset) = buffer->index;
        return 0;
      case VIDIOC_QBUF:
        if (!names_planes(*buffer)) {
          return -EINVAL;
        }
        queued_.push_back(buffer->index);
        return 0;
      case VIDIOC_DQBUF:
        return give(buffer);
      case VIDIOC_STREAMON:
        streaming = true;
        sequence_ = 0;
        return 0;
      case VIDIOC_STREAMOFF:
        streaming = false;
        return 0;
      default:
        return -ENOTTY;
    }
  }

  int give(v4l2_buffer* buffer) {
    if (failed) {
      return -EIO;
    }
    if (filled_.empty()) {
      return -EAGAIN;
    }
    if (!names_planes(*buffer)) {
      return -EINVAL;
    }
    v4l2_plane* const theirs = buffer->m.planes;
    *buffer = filled_.front();
    if (planes > 0) {
      buffer->m.planes = theirs;
      theirs[0].bytesused = buffer->bytesused;
      theirs[0].data_offset = bytes_before;
    }
    buffer->index += lie_about_index;
    filled_.pop_front();
    return 0;
  }

  [[nodiscard]] bool names_planes(const v4l2_buffer& buffer) const {
    return planes == 0 ? buffer.type == V4L2_BUF_TYPE_VIDEO_CAPTURE
                       : buffer.type == V4L2_BUF_TYPE_VIDEO_CAPTURE_MPLANE &&
                             buffer.length == planes && buffer.m.planes != nullptr;
  }

  int set_planes(v4l2_pix_format_mplane* pix) const {
    for (const std::uint32_t known : formats) {
      if (pix->pixelformat == known) {
        pix->width = width;
        pix->height = height;
        pix->field = static_cast<std::uint8_t>(field);
        pix->num_planes = static_cast<std::uint8_t>(planes);
        pix->plane_fmt[0].bytesperline = width + row_padding;
        pix->plane_fmt[0].sizeimage = image_bytes();
        return 0;
      }
    }
    pix->pixelformat = formats.front();
    return 0;
  }

  int set_format(v4l2_format* format) const {
    if (planes > 0) {
      return format->type == V4L2_BUF_TYPE_VIDEO_CAPTURE_MPLANE ? set_planes(&format->fmt.pix_mp)
                                                                : -EINVAL;
    }
    v4l2_pix_format& pix = format->fmt.pix;
    for (const std::uint32_t known : formats) {
      if (pix.pixelformat == known) {
        pix.width = width;
        pix.height = height;
        pix.field = field;
        pix.bytesperline = width + row_padding;
        pix.sizeimage = image_bytes();
        return 0;
      }
    }
    pix.pixelformat = formats.front();
    return 0;
  }

  int query_control(v4l2_queryctrl* query) const {
    if (!has_exposure || (query->id != V4L2_CID_EXPOSURE_ABSOLUTE && query->id != V4L2_CID_GAIN)) {
      return -EINVAL;
    }
    query->minimum = 1;
    query->maximum = 1000;
    query->step = 1;
    return 0;
  }

  [[nodiscard]] std::uint32_t image_bytes() const {
    return bytes_before + (width + row_padding) * height;
  }

  std::vector<std::vector<std::uint8_t>> memory_;
  std::deque<std::uint32_t> queued_;
  std::deque<v4l2_buffer> filled_;
  std::uint32_t sequence_ = 0;
};

}  // namespace polhode::platform
