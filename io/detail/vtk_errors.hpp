// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>
#include <vtkCallbackCommand.h>
#include <vtkNew.h>
#include <vtkObject.h>

namespace nav::io::detail {

/// Stores the first error of the VTK objects that it watches. An object with an observer prints
/// nothing. Must outlive the use of these objects.
class VtkErrors {
 public:
  VtkErrors();
  void watch(vtkObject* object);
  /// Calls a function that uses VTK; an exception becomes the first error.
  void run(const std::function<void()>& call);
  /// First error as one line; empty when there was none.
  [[nodiscard]] const std::string& first() const { return first_; }

 private:
  vtkNew<vtkCallbackCommand> callback_;
  std::string first_;
};

/// Turns off the messages that GDCM, the decoder of vtkDICOMReader, prints; its failures are
/// reported through VTK. It applies to the whole process and needs to be called only once.
void silence_gdcm();

}  // namespace nav::io::detail
