# SPDX-License-Identifier: MIT
# Toolchain file of CMake for avr-gcc: cmake --toolchain PREFIX/lib/cmake/cds55xx/avr-gcc.cmake -S . -B build
# The option -mmcu comes with the target cds55xx::<mcu>.
set(CMAKE_SYSTEM_NAME Generic)
set(CMAKE_SYSTEM_PROCESSOR avr)

foreach(_cds55xx_tool avr-gcc avr-g++ avr-gcc-ar avr-gcc-ranlib)
    find_program(CDS55XX_${_cds55xx_tool} ${_cds55xx_tool})
    if(NOT CDS55XX_${_cds55xx_tool})
        message(FATAL_ERROR "${_cds55xx_tool} is not in PATH; Debian: apt-get install gcc-avr binutils-avr avr-libc")
    endif()
endforeach()
set(CMAKE_C_COMPILER "${CDS55XX_avr-gcc}")
set(CMAKE_CXX_COMPILER "${CDS55XX_avr-g++}")
set(CMAKE_ASM_COMPILER "${CDS55XX_avr-gcc}")
set(CMAKE_AR "${CDS55XX_avr-gcc-ar}" CACHE FILEPATH "an ar that knows objects for link-time optimisation")
set(CMAKE_RANLIB "${CDS55XX_avr-gcc-ranlib}" CACHE FILEPATH "a ranlib that knows these objects")

# Without a chip no program can be linked: CMake tries the compiler with a library.
set(CMAKE_TRY_COMPILE_TARGET_TYPE STATIC_LIBRARY)
set(CMAKE_EXECUTABLE_SUFFIX_C .elf)
set(CMAKE_EXECUTABLE_SUFFIX_CXX .elf)

# find_package(cds55xx) finds the package beside this file, and no package of the host.
get_filename_component(_cds55xx_prefix "${CMAKE_CURRENT_LIST_DIR}/../../.." ABSOLUTE)
list(APPEND CMAKE_PREFIX_PATH "${_cds55xx_prefix}")
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
