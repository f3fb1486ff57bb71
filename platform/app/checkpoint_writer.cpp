#include "app/checkpoint_writer.hpp"

#include "os/linux/clock.hpp"

namespace polhode::platform {

std::int64_t utc_now_ns() { return clock_ns(CLOCK_REALTIME); }

CheckpointWriter::CheckpointWriter(const std::filesystem::path& file,
                                   const CheckpointIdentity& identity,
                                   std::uint32_t restarts)
    : places_(file),
      stamp_{.identity = identity, .restarts = restarts},
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

void CheckpointWriter::offer(const Component& component, std::int64_t stepped_utc_ns) {
  const bool sound = may_be_saved(component);
  {
    const std::lock_guard lock(mutex_);
    if (waiting_ > 0 || !sound) {
      ++counters_.skipped;
      return;
    }
  }
  const std::size_t octets = save_checkpoint(component, buffer_);
  stamp_.utc_ns = stepped_utc_ns;
  {
    const std::lock_guard lock(mutex_);
    waiting_ = octets;
  }
  changed_.notify_all();
}

void CheckpointWriter::write_now(const Component& component, std::int64_t stepped_utc_ns) {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return waiting_ == 0; });
  if (stepped_utc_ns == written_utc_ns_) {
    return;  // twice the same would push out the one before
  }
  lock.unlock();
  offer(component, stepped_utc_ns);
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
    const std::size_t octets = waiting_;
    lock.unlock();
    const bool written = write_checkpoint_file(places_, stamp_, buffer_.first(octets));
    lock.lock();
    ++(written ? counters_.written : counters_.failed);
    written_utc_ns_ = written ? stamp_.utc_ns : written_utc_ns_;
    counters_.octets = octets;
    waiting_ = 0;
    changed_.notify_all();
  }
}

}  // namespace polhode::platform
