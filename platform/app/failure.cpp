#include "app/failure.hpp"

#include <pthread.h>

#include "app/crash_mark.hpp"
#include "base/assert.hpp"
#include "os/linux/assertion.hpp"
#include "os/linux/memory/region.hpp"

namespace polhode::platform {
namespace {

/// For the hooks, which are plain functions; one run at a time.
struct Subject {
  const Component* component = nullptr;
  CheckpointWriter* writer = nullptr;
  pthread_t stepping{};
};
Subject g_subject;

/// Writes once, even if writing itself fails and calls this again.
void write_checkpoint(const Subject& subject) {
  g_subject = {};
  if (subject.component == nullptr || pthread_equal(pthread_self(), subject.stepping) == 0) {
    return;
  }
  unseal_memory();  // the program ends anyway: writing may take memory from the machine
  subject.writer->write_now(*subject.component, moment_now());
}

void of_exhaustion(Pool /*pool*/, std::size_t /*bytes*/) {
  const Subject subject = g_subject;
  leave_crash_mark();
  write_checkpoint(subject);
}

void of_assertion(const AssertionReport& report) {
  const Subject subject = g_subject;
  print_assertion(report);
  if (!leave_crash_mark()) {
    write_checkpoint(subject);
  }
}

}  // namespace

CheckpointOnFailure::CheckpointOnFailure(const Component& component, CheckpointWriter& writer) {
  g_subject = {.component = &component, .writer = &writer, .stepping = pthread_self()};
  set_exhaustion_hook(of_exhaustion);
  set_assertion_hook(of_assertion);
}

CheckpointOnFailure::~CheckpointOnFailure() {
  set_exhaustion_hook(nullptr);
  print_assertions();
  g_subject = {};
}

}  // namespace polhode::platform
