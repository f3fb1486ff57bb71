#include "app/observations.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <system_error>
#include <type_traits>

#include "errors.hpp"

namespace polhode::platform {

static_assert(std::is_trivially_copyable_v<Observation>, "the spool keeps its octets");

ObservationTable::ObservationTable(const std::filesystem::path& file) : out_(file) {
  out_.write("frame,timestamp_ns,landmark,u_px,v_px,predicted_u_px,predicted_v_px,inlier\n");
}

void ObservationTable::append(std::size_t frame,
                              std::int64_t timestamp_ns,
                              std::span<const Observation> observations) {
  text_.clear();
  for (const Observation& seen : observations) {
    auto out = std::back_inserter(text_);
    fmt::format_to(out, "{},{},", frame, timestamp_ns);
    if (seen.landmark >= 0) {
      fmt::format_to(out,
                     "{},{:.2f},{:.2f},{:.2f},{:.2f},{:d}\n",
                     seen.landmark,
                     seen.u_px,
                     seen.v_px,
                     seen.predicted_u_px,
                     seen.predicted_v_px,
                     seen.inlier);
    } else {
      fmt::format_to(out, ",{:.2f},{:.2f},,,{:d}\n", seen.u_px, seen.v_px, seen.inlier);
    }
  }
  out_.write(text_);
}

ObservationSpool::ObservationSpool(const std::filesystem::path& file, std::size_t frames)
    : file_(file), stream_(std::fopen(file.c_str(), "w+be")) {
  if (!stream_) {
    fail();
  }
  ends_.reserve(frames);
}

ObservationSpool::~ObservationSpool() {
  stream_.reset();
  std::error_code
      ignored;  // a temporary file that stays behind does no harm: the next run removes it
  std::filesystem::remove(file_, ignored);
}

void ObservationSpool::append(std::span<const Observation> observations) {
  buffer_.clear();
  std::copy_if(observations.begin(),
               observations.end(),
               std::back_inserter(buffer_),
               [](const Observation& seen) { return seen.inlier && seen.landmark >= 0; });
  if (!buffer_.empty() &&
      std::fwrite(buffer_.data(), sizeof(Observation), buffer_.size(), stream_.get()) !=
          buffer_.size()) {
    fail();
  }
  ends_.push_back((ends_.empty() ? 0 : ends_.back()) + buffer_.size());
}

std::span<const Observation> ObservationSpool::of_frame(std::size_t frame) {
  const std::uint64_t first = frame == 0 ? 0 : ends_.at(frame - 1);
  buffer_.resize(ends_.at(frame) - first);
  const auto offset = static_cast<off_t>(first * sizeof(Observation));
  if (::fseeko(stream_.get(), offset, SEEK_SET) != 0 ||
      std::fread(buffer_.data(), sizeof(Observation), buffer_.size(), stream_.get()) !=
          buffer_.size()) {
    fail();
  }
  return buffer_;
}

void ObservationSpool::fail() const {
  throw RunFailure(fmt::format("{}: cannot be written or read back: {}",
                               file_.string(),
                               std::generic_category().message(errno)));
}

}  // namespace polhode::platform
