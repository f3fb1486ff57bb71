// A thread for work that must not hold the frames up: a small stack, no signals, joined at the end.
#pragma once

#include <pthread.h>

namespace polhode::platform {

class BackgroundThread {
 public:
  BackgroundThread() = default;
  ~BackgroundThread() { join(); }
  BackgroundThread(const BackgroundThread&) = delete;
  BackgroundThread& operator=(const BackgroundThread&) = delete;

  /// @param work runs until it returns; the caller signals it to end, and then joins.
  /// @throws RunFailure when there is no thread to be had.
  void start(void (*work)(void* context), void* context);
  void join();

 private:
  struct Call {
    void (*work)(void*) = nullptr;
    void* context = nullptr;
  };
  static void* main(void* call);

  Call call_;
  pthread_t thread_{};
  bool started_ = false;
};

}  // namespace polhode::platform
