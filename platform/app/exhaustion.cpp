#include "app/exhaustion.hpp"

#include <pthread.h>

#include "app/crash_mark.hpp"
#include "os/linux/memory/region.hpp"

namespace polhode::platform {
namespace {

/// For the hook, which is a plain function; one run at a time.
struct Subject {
  const Component* component = nullptr;
  CheckpointWriter* writer = nullptr;
  pthread_t stepping{};
};
Subject g_subject;

void write_checkpoint(Pool /*pool*/, std::size_t /*octets*/) {
  const Subject subject = g_subject;
  g_subject = {};  // once, should writing come back here
  leave_crash_mark();
  if (subject.component == nullptr || pthread_equal(pthread_self(), subject.stepping) == 0) {
    return;
  }
  unseal_memory();  // the program ends anyway: what writing needs may come from the machine
  subject.writer->write_now(*subject.component, utc_now_ns());
}

}  // namespace

CheckpointOnExhaustion::CheckpointOnExhaustion(const Component& component,
                                               CheckpointWriter& writer) {
  g_subject = {.component = &component, .writer = &writer, .stepping = pthread_self()};
  set_exhaustion_hook(write_checkpoint);
}

CheckpointOnExhaustion::~CheckpointOnExhaustion() {
  set_exhaustion_hook(nullptr);
  g_subject = {};
}

}  // namespace polhode::platform
