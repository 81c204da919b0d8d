// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// A separate program, because its `new` counts.
#include <atomic>
#include <cmath>
#include <cstdlib>
#include <gtest/gtest.h>
#include <new>

#include "tracking/pose_buffer.hpp"
#include "tracking/pose_gate.hpp"

namespace {
std::atomic<int> allocations{0};
}  // namespace

// Not inlined: the compiler would see malloc() and delete as a mismatch.
__attribute__((noinline)) void* operator new(std::size_t bytes) {
  ++allocations;
  void* memory = std::malloc(bytes);
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}
__attribute__((noinline)) void operator delete(void* memory) noexcept { std::free(memory); }
__attribute__((noinline)) void operator delete(void* memory, std::size_t) noexcept {
  std::free(memory);
}

namespace nav::tracking {
namespace {

TEST(AllocationTest, AnAdmittedPoseAllocatesNothing) {
  PoseGate<frames::Reference> gate;  // The longest name of a body.
  PoseBuffer<frames::Reference> buffer(64);
  int admitted = 0;
  const int before = allocations;
  for (int i = 0; i < 2000; ++i) {
    RawPose raw;
    raw.acquired = Timestamp(std::chrono::milliseconds(10 * i));
    raw.received = raw.acquired + std::chrono::microseconds(15000 + i % 7 * 100);
    raw.status = TrackingStatus::kOk;
    raw.tracker_from_body = Eigen::Matrix4d::Identity();
    raw.tracker_from_body(0, 3) = 20 * std::sin(0.01 * i);
    auto admission = gate.admit(raw);
    admitted += admission.rejection ? 0 : 1;
    buffer.push(std::move(admission.pose));
  }
  EXPECT_EQ(allocations - before, 0);
  EXPECT_EQ(admitted, 2000);
}

}  // namespace
}  // namespace nav::tracking
