// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>
#include <vtkCallbackCommand.h>
#include <vtkNew.h>
#include <vtkObject.h>

namespace nav::io::detail {

/// Keeps the first error of the VTK objects that it watches; with an observer VTK prints nothing.
/// Must outlive their use.
class VtkErrors {
 public:
  VtkErrors();
  void watch(vtkObject* object);
  /// Runs something of these libraries; an exception becomes the first error.
  void run(const std::function<void()>& call);
  /// One line; empty when nothing went wrong.
  [[nodiscard]] const std::string& first() const { return first_; }

 private:
  vtkNew<vtkCallbackCommand> callback_;
  std::string first_;
};

/// Turns off what GDCM, the decoder beneath vtkDICOMReader, prints on its own; its failures reach
/// us through VTK. For the whole process, once.
void silence_gdcm();

}  // namespace nav::io::detail
