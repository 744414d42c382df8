# neurframe_eigen: the Eigen headers, from the system or from the PyPI package cmeel-eigen (a build requirement).
find_package(Eigen3 3.4 QUIET NO_MODULE)
if(NOT TARGET Eigen3::Eigen)
  find_package(Python3 COMPONENTS Interpreter QUIET)
  if(Python3_FOUND)
    execute_process(
      COMMAND ${Python3_EXECUTABLE} -c "import sys, pathlib; print(next((str(p / 'cmeel.prefix') for p in map(pathlib.Path, sys.path) if (p / 'cmeel.prefix').is_dir()), ''))"
      OUTPUT_VARIABLE cmeel_prefix OUTPUT_STRIP_TRAILING_WHITESPACE)
    if(cmeel_prefix)
      find_package(Eigen3 REQUIRED NO_MODULE PATHS ${cmeel_prefix})
    endif()
  endif()
endif()
if(NOT TARGET Eigen3::Eigen)
  message(FATAL_ERROR "Eigen is missing: pip install cmeel-eigen, or apt-get install libeigen3-dev")
endif()
add_library(neurframe_eigen INTERFACE)
target_link_libraries(neurframe_eigen INTERFACE Eigen3::Eigen)
# Eigen's headers are not ours to warn about
get_target_property(eigen_include Eigen3::Eigen INTERFACE_INCLUDE_DIRECTORIES)
target_include_directories(neurframe_eigen SYSTEM INTERFACE ${eigen_include})
