#include "os/linux/background_thread.hpp"

#include <csignal>
#include <cstddef>

#include "errors.hpp"

namespace polhode::platform {

void* BackgroundThread::main(void* call) {
  const auto* todo = static_cast<const Call*>(call);
  todo->work(todo->context);
  return nullptr;
}

void BackgroundThread::start(void (*work)(void* context), void* context) {
  constexpr std::size_t kStackBytes = std::size_t{256} << 10U;
  call_ = {.work = work, .context = context};
  // The thread inherits the mask: a signal then ends the frame loop's waits, not this thread's.
  sigset_t all;
  sigset_t before;
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &before);
  pthread_attr_t attributes;
  pthread_attr_init(&attributes);
  pthread_attr_setstacksize(&attributes, kStackBytes);
  const int refused = pthread_create(&thread_, &attributes, &BackgroundThread::main, &call_);
  pthread_attr_destroy(&attributes);
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
  if (refused != 0) {
    throw RunFailure("no thread to be had for writing to the disk");
  }
  started_ = true;
}

void BackgroundThread::join() {
  if (started_) {
    pthread_join(thread_, nullptr);
    started_ = false;
  }
}

}  // namespace polhode::platform
