#include "recording/recorder.hpp"

#include <lz4.h>

#include <algorithm>
#include <chrono>
#include <cstring>

#include "base/assert.hpp"
#include "base/crc.hpp"

namespace polhode::platform {
namespace {

constexpr std::size_t kCommandOctetsMax = 65542;  // the longest CCSDS packet

constexpr std::size_t aligned(std::size_t bytes) { return (bytes + 63) / 64 * 64; }

std::size_t compressed_bytes(std::size_t bytes) {
  return static_cast<std::size_t>(LZ4_compressBound(static_cast<int>(bytes)));
}

std::span<const std::uint8_t> bytes_of(const std::string& text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

}  // namespace

std::size_t Recorder::bytes_needed(std::size_t slots, std::size_t frame_bytes_max) {
  const std::size_t slot = std::max(frame_bytes_max, kCommandOctetsMax);
  return slots * aligned(slot) + aligned(frame_bytes_max) +
         aligned(compressed_bytes(frame_bytes_max)) +
         aligned(static_cast<std::size_t>(LZ4_sizeofState()));
}

Recorder::Recorder(const RecorderOptions& options, std::string begin, std::size_t frame_bytes_max)
    : complete_(options.complete),
      begin_(std::move(begin)),
      segments_(options.folder, options.run_utc_ns, options.limits),
      slots_(options.slots),
      memory_(bytes_needed(options.slots, frame_bytes_max)) {
  std::span<std::byte> left = memory_.span();
  const auto take = [&left](std::size_t bytes) {
    const std::span<std::uint8_t> taken(reinterpret_cast<std::uint8_t*>(left.data()), bytes);
    left = left.subspan(aligned(bytes));
    return taken;
  };
  for (Slot& slot : slots_) {
    slot.content = take(std::max(frame_bytes_max, kCommandOctetsMax));
  }
  differences_ = take(frame_bytes_max);
  compressed_ = take(compressed_bytes(frame_bytes_max));
  lz4_state_ = take(static_cast<std::size_t>(LZ4_sizeofState()));
  thread_.start(&Recorder::work, this);
}

Recorder::~Recorder() {
  if (missed_since_ > 0) {
    // Marked by an empty slot of its own: the run is over, and may wait.
    (void)claim_in_turn(Patience::kEndless);
  }
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

Recorder::Slot* Recorder::claim(Patience patience) {
  // Long for a thread that writes a few bytes, short beside a frame.
  constexpr std::chrono::milliseconds kShort{5};
  std::unique_lock lock(mutex_);
  const auto is_free = [this] { return filled_ < slots_.size(); };
  if (patience == Patience::kEndless) {
    changed_.wait(lock, is_free);
  } else if (patience == Patience::kShort) {
    (void)changed_.wait_for(lock, kShort, is_free);
  }
  return is_free() ? &slots_[(first_ + filled_) % slots_.size()] : nullptr;
}

Recorder::Slot* Recorder::claim_in_turn(Patience patience) {
  Slot* slot = claim(patience);
  if (slot == nullptr || missed_since_ == 0) {
    return slot;
  }
  slot->header = {
      .kind = RecordKind::kDropped, .reason = DropReason::kNotRecorded, .count = missed_since_};
  missed_since_ = 0;
  commit();
  return claim(patience);
}

void Recorder::miss() {
  ++missed_since_;
  const std::lock_guard lock(mutex_);
  ++counters_.missed;
}

void Recorder::commit() {
  {
    const std::lock_guard lock(mutex_);
    ++filled_;
  }
  changed_.notify_all();
}

void Recorder::checkpoint(std::span<const std::uint8_t> bytes) {
  // Nothing waits for this thread yet, and the other has nothing to write: the file is ours.
  const bool written = write_in_turn({.kind = RecordKind::kCheckpoint}, bytes);
  const std::lock_guard lock(mutex_);
  counters_.write_failures += written ? 0 : 1;
}

void Recorder::frame(const Frame& frame) {
  Slot* slot = claim_in_turn(complete_ ? Patience::kEndless : Patience::kNone);
  if (slot == nullptr) {
    miss();
    return;
  }
  const ImageView& image = frame.image;
  const bool deep = image.format == PixelFormat::kGray16;
  slot->header = {.kind = RecordKind::kFrame,
                  .readable = frame.readable,
                  .deep = deep,
                  .width_px = static_cast<std::uint16_t>(image.width_px),
                  .height_px = static_cast<std::uint16_t>(image.height_px),
                  .timestamp_ns = frame.timestamp_ns};
  if (frame.readable) {
    const std::size_t row = static_cast<std::size_t>(image.width_px) * (deep ? 2 : 1);
    slot->header.bytes =
        static_cast<std::uint32_t>(row * static_cast<std::size_t>(image.height_px));
    POLHODE_ASSERT(slot->header.bytes <= slot->content.size(), slot->header.bytes);
    for (int v = 0; v < image.height_px; ++v) {
      std::memcpy(slot->content.data() + static_cast<std::size_t>(v) * row,
                  image.data + v * image.stride_bytes,
                  row);
    }
  }
  commit();
}

void Recorder::dropped(DropReason reason, std::uint32_t count) {
  if (Slot* slot = claim(complete_ ? Patience::kEndless : Patience::kNone)) {
    slot->header = {.kind = RecordKind::kDropped, .reason = reason, .count = count};
    commit();
  }
}

void Recorder::command(std::span<const std::uint8_t> packet) {
  // Rare, and small: the thread gets a moment to write them. A disk that hangs is not waited for.
  const Patience brief = missed_since_ == 0 ? Patience::kShort : Patience::kNone;
  Slot* slot = claim_in_turn(complete_ ? Patience::kEndless : brief);
  if (slot == nullptr) {
    miss();
    return;
  }
  const std::size_t bytes = std::min(packet.size(), slot->content.size());
  slot->header = {.kind = RecordKind::kCommand, .bytes = static_cast<std::uint32_t>(bytes)};
  std::copy_n(packet.begin(), bytes, slot->content.begin());
  commit();
}

RecorderCounters Recorder::counters() {
  const std::lock_guard lock(mutex_);
  return counters_;
}

void Recorder::work(void* recorder) { static_cast<Recorder*>(recorder)->serve(); }

void Recorder::serve() {
  std::unique_lock lock(mutex_);
  for (;;) {
    changed_.wait(lock, [this] { return stop_ || filled_ > 0; });
    if (filled_ == 0) {
      (void)record_refused();
      return;  // a stop was requested, and all is written
    }
    Slot& slot = slots_[first_];
    lock.unlock();
    write_slot(slot);
    lock.lock();
    first_ = (first_ + 1) % slots_.size();
    --filled_;
    changed_.notify_all();
  }
}

/// Leaves the content as it is where compression gains nothing.
void Recorder::compress(Slot& slot, std::span<const std::uint8_t>* content) {
  difference_rows(*content, slot.header.width_px, slot.header.deep, differences_.data());
  const int bytes = LZ4_compress_fast_extState(lz4_state_.data(),
                                               reinterpret_cast<const char*>(differences_.data()),
                                               reinterpret_cast<char*>(compressed_.data()),
                                               static_cast<int>(content->size()),
                                               static_cast<int>(compressed_.size()),
                                               1);
  if (bytes > 0 && static_cast<std::size_t>(bytes) < content->size()) {
    slot.header.packing = RecordPacking::kDifferenceLz4;
    *content = compressed_.first(static_cast<std::size_t>(bytes));
  }
}

void Recorder::write_slot(Slot& slot) {
  std::span<const std::uint8_t> content = slot.content.first(slot.header.bytes);
  slot.header.packing = RecordPacking::kRaw;
  const bool has_image = slot.header.kind == RecordKind::kFrame && slot.header.readable;
  if (has_image) {
    compress(slot, &content);
  }
  const bool written = write_in_turn(slot.header, content);
  const std::lock_guard lock(mutex_);
  counters_.frames += slot.header.kind == RecordKind::kFrame && written ? 1 : 0;
  counters_.write_failures += written ? 0 : 1;
  counters_.bytes += written ? kRecordHeaderBytes + content.size() : 0;
}

bool Recorder::record_refused() {
  if (refused_ > 0 &&
      write_record(
          {.kind = RecordKind::kDropped, .reason = DropReason::kNotRecorded, .count = refused_},
          {})) {
    refused_ = 0;
  }
  return refused_ == 0;
}

bool Recorder::write_in_turn(const RecordHeader& header, std::span<const std::uint8_t> content) {
  const bool written = record_refused() && write_record(header, content);
  refused_ += written ? 0 : std::max(1U, header.count);
  return written;
}

bool Recorder::write_record(RecordHeader header, std::span<const std::uint8_t> content) {
  const auto whole = [this](RecordHeader h, std::span<const std::uint8_t> c) {
    h.bytes = static_cast<std::uint32_t>(c.size());
    h.content_crc32 = crc32_iso_hdlc(c);
    return segments_.write(encode(h)) && segments_.write(c);
  };
  if (segments_.wants_next(kRecordHeaderBytes + content.size())) {
    if (!segments_.begin_next()) {
      return false;
    }
    if (!whole({.kind = RecordKind::kBegin}, bytes_of(begin_))) {
      segments_.abandon_present();
      return false;
    }
  }
  return whole(header, content);
}

}  // namespace polhode::platform
