// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Does on purpose what a sanitizer must detect. CTest expects this program to fail. If it passes,
// the flags of the sanitizer did not reach the compiler.
#include <cstdio>
#include <string>
#include <thread>

int main(int argc, char** argv) {
  const std::string kind = argc > 1 ? argv[1] : "";
  if (kind == "address") {
    int* numbers = new int[4];
    delete[] numbers;
    std::printf("%d\n", static_cast<volatile int*>(numbers)[argc]);
  } else if (kind == "undefined") {
    volatile int large = 2147483647;
    std::printf("%d\n", large + argc);
  } else if (kind == "thread") {
    int shared = 0;
    std::thread other([&] { static_cast<volatile int&>(shared) = 1; });
    static_cast<volatile int&>(shared) = 2;
    other.join();
    std::printf("%d\n", shared);
  }
  return 0;
}
