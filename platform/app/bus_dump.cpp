#include "app/bus_dump.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cerrno>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <system_error>
#include <vector>

#include "app/motion_csv.hpp"
#include "bus/splitter.hpp"
#include "bus/telemetry.hpp"
#include "errors.hpp"

namespace polhode::platform {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kChunkOctets =
    1U << 16U;  // some hundred packets; memory does not depend on the file's size

struct Close {
  void operator()(std::FILE* stream) const { std::fclose(stream); }
};

template <typename T>
Json known(bool valid, const T& value) {
  return valid ? Json(value) : Json();
}

Json as_json(const bus::PacketHeader& header, const MotionState& motion) {
  return {{"packet", "motion"},
          {"apid", header.apid},
          {"sequence", header.sequence},
          {"frame", motion.frame},
          {"timestamp_ns", motion.timestamp_ns},
          {"mode", mode_name(motion.mode)},
          {"pose_valid", motion.pose_valid},
          {"rate_valid", motion.rate_valid},
          {"velocity_valid", motion.velocity_valid},
          {"scale_known", motion.scale_known},
          {"q_CT", known(motion.pose_valid, motion.q_CT)},
          {"p_CT", known(motion.pose_valid, motion.p_CT)},
          {"v_C", known(motion.velocity_valid, motion.v_C)},
          {"w_T_rad_s", known(motion.rate_valid, motion.w_T_rad_s)},
          {"sigma_att_rad", known(motion.pose_valid, motion.sigma_att_rad)},
          {"sigma_pos", known(motion.pose_valid, motion.sigma_pos)},
          {"sigma_vel", known(motion.velocity_valid, motion.sigma_vel)},
          {"sigma_rate_rad_s", known(motion.rate_valid, motion.sigma_rate_rad_s)},
          {"features", motion.features},
          {"matches", motion.matches},
          {"inliers", motion.inliers},
          {"landmarks", motion.landmarks},
          {"keyframes", motion.keyframes}};
}

template <std::size_t kCount>
std::string column(bool valid, const std::array<double, kCount>& values) {
  return valid ? fmt::format("{:+.5f}", fmt::join(values, " ")) : std::string("-");
}

std::string as_row(const bus::PacketHeader& header, const MotionState& motion) {
  return fmt::format("{:>5} {:>6} {:>19} {:<9} {:<35} {:<26} {:<26} {:<26} {:>7}",
                     header.sequence,
                     motion.frame,
                     motion.timestamp_ns,
                     mode_name(motion.mode),
                     column(motion.pose_valid, motion.q_CT),
                     column(motion.pose_valid, motion.p_CT),
                     column(motion.velocity_valid, motion.v_C),
                     column(motion.rate_valid, motion.w_T_rad_s),
                     motion.inliers);
}

void print_head() {
  fmt::print("{:>5} {:>6} {:>19} {:<9} {:<35} {:<26} {:<26} {:<26} {:>7}\n",
             "count",
             "frame",
             "timestamp_ns",
             "mode",
             "q_CT w x y z",
             "p_CT",
             "v_C",
             "w_T rad/s",
             "inliers");
}

/// Prints packets one by one and counts what was wrong.
class Dump {
 public:
  explicit Dump(const BusDumpArguments& arguments) : arguments_(arguments) {}

  void packet(const bus::PacketHeader& header, std::span<const std::uint8_t> octets) {
    tell_damage();
    if (packets_++ == 0 && !arguments_.json) {
      print_head();
    }
    if (packets_ > 1 && last_.apid == header.apid) {
      missing_ += bus::packets_missing(last_.sequence, header.sequence);
    }
    last_ = header;
    const Result<MotionState> motion = decode_motion(octets);
    if (!motion) {
      fmt::print(
          stderr, "packet {} of APID {}: {}\n", packets_ - 1, header.apid, motion.error().message);
    } else if (arguments_.json) {
      fmt::print("{}\n", as_json(header, motion.value()).dump());
    } else {
      fmt::print("{}\n", as_row(header, motion.value()));
    }
  }

  /// Told only once packets stand beside it: a file of something else gets one line, not hundreds.
  void damage(std::uint64_t offset, std::size_t octets) {
    if (damage_octets_ == 0) {
      damage_offset_ = offset;
    }
    damage_octets_ += octets;
    damaged_total_ += octets;
  }

  void finish() {
    if (packets_ == 0 && damaged_total_ != 0) {
      throw UnusableInput(fmt::format("{}: holds no packet", arguments_.file.string()));
    }
    tell_damage();
    fmt::print(stderr,
               "{} packets, {} missing by their counts, {} octets damaged\n",
               packets_,
               missing_,
               damaged_total_);
  }

 private:
  void tell_damage() {
    if (damage_octets_ != 0) {
      fmt::print(stderr,
                 "{}: {} octets at offset {} are no packet\n",
                 arguments_.file.string(),
                 damage_octets_,
                 damage_offset_);
      damage_octets_ = 0;
    }
  }

  const BusDumpArguments& arguments_;
  bus::PacketHeader last_;
  std::uint64_t packets_ = 0;
  std::uint64_t missing_ = 0;
  std::uint64_t damaged_total_ = 0;
  std::uint64_t damage_offset_ = 0;  ///< of the damage since the last packet
  std::uint64_t damage_octets_ = 0;
};

/// Hands over the whole pieces at the front of the stream. @return octets used up.
std::size_t take_pieces(std::span<const std::uint8_t> stream,
                        std::uint64_t stream_offset,
                        bool at_end,
                        Dump& dump) {
  std::size_t at = 0;
  while (at < stream.size()) {
    const bus::StreamPiece piece = bus::next_piece(stream, at, at_end);
    if (piece.kind == bus::PieceKind::kIncomplete) {
      break;
    }
    if (piece.kind == bus::PieceKind::kPacket) {
      dump.packet(piece.header, stream.subspan(piece.offset, piece.octets));
    } else {
      dump.damage(stream_offset + piece.offset, piece.octets);
    }
    at += piece.octets;
  }
  return at;
}

}  // namespace

void dump_bus(const BusDumpArguments& arguments) {
  const std::unique_ptr<std::FILE, Close> in(std::fopen(arguments.file.c_str(), "rbe"));
  if (!in) {
    throw UnusableInput(
        fmt::format("{}: {}", arguments.file.string(), std::generic_category().message(errno)));
  }
  Dump dump(arguments);
  std::vector<std::uint8_t> buffer;
  std::uint64_t offset = 0;
  bool at_end = false;
  while (!at_end) {
    const std::size_t held = buffer.size();
    buffer.resize(held + kChunkOctets);
    const std::size_t count = std::fread(buffer.data() + held, 1, kChunkOctets, in.get());
    if (std::ferror(in.get()) != 0) {
      throw UnusableInput(fmt::format("{}: cannot be read", arguments.file.string()));
    }
    buffer.resize(held + count);
    at_end = count == 0;
    const std::size_t used = take_pieces(buffer, offset, at_end, dump);
    buffer.erase(buffer.begin(), buffer.begin() + static_cast<std::ptrdiff_t>(used));
    offset += used;
  }
  dump.finish();
}

}  // namespace polhode::platform
