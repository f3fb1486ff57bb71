#include "app/checkpoint_writer.hpp"

#include "os/linux/clock.hpp"

namespace polhode::platform {

std::int64_t utc_now_ns() { return clock_ns(CLOCK_REALTIME); }

CheckpointWriter::CheckpointWriter(const std::filesystem::path& file,
                                   const CheckpointIdentity& identity,
                                   std::uint32_t restarts,
                                   const std::optional<polhode_key>& key)
    : places_(file),
      key_(key),
      stamp_{.identity = identity, .boot_id = this_boot(), .stepped = {}, .restarts = restarts},
      memory_(checkpoint_octets_max()),
      buffer_(reinterpret_cast<std::uint8_t*>(memory_.span().data()), memory_.span().size()) {
  thread_.start(&CheckpointWriter::work, this);
}

CheckpointWriter::~CheckpointWriter() {
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

void CheckpointWriter::offer(const Component& component, const Moment& stepped) {
  const bool validity = may_be_saved(component);
  {
    const std::lock_guard lock(mutex_);
    if (waiting_ > 0 || !validity) {
      ++counters_.skipped;
      return;
    }
  }
  const std::size_t bytes = save_checkpoint(component, buffer_);
  stamp_.stepped = stepped;
  {
    const std::lock_guard lock(mutex_);
    waiting_ = bytes;
  }
  changed_.notify_all();
}

void CheckpointWriter::write_now(const Component& component, const Moment& stepped) {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return waiting_ == 0; });
  if (stepped.since_boot_ns == written_since_boot_ns_) {
    return;  // twice the same would push out the one before
  }
  lock.unlock();
  offer(component, stepped);
  lock.lock();
  changed_.wait(lock, [this] { return waiting_ == 0; });
}

CheckpointCounters CheckpointWriter::counters() {
  const std::lock_guard lock(mutex_);
  return counters_;
}

void CheckpointWriter::work(void* writer) { static_cast<CheckpointWriter*>(writer)->serve(); }

void CheckpointWriter::serve() {
  std::unique_lock lock(mutex_);
  for (;;) {
    changed_.wait(lock, [this] { return stop_ || waiting_ > 0; });
    if (waiting_ == 0) {
      return;
    }
    const std::size_t bytes = waiting_;
    lock.unlock();
    const bool written =
        write_checkpoint_file(places_, stamp_, buffer_.first(bytes), key_ ? &*key_ : nullptr);
    lock.lock();
    ++(written ? counters_.written : counters_.failed);
    written_since_boot_ns_ = written ? stamp_.stepped.since_boot_ns : written_since_boot_ns_;
    counters_.bytes = bytes;
    waiting_ = 0;
    changed_.notify_all();
  }
}

}  // namespace polhode::platform
