# What every target of the project is compiled with. -ffast-math stays out: it breaks factorisations
# and hides NaNs.
if(NOT CMAKE_BUILD_TYPE)
  set(CMAKE_BUILD_TYPE Release CACHE STRING "Build type" FORCE)
endif()
set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/bin)
set(CMAKE_CXX_FLAGS_RELEASE "-O3 -DNDEBUG")
# Everywhere, because it defines a macro: a precompiled header is taken only with the same macros.
add_compile_options(-pthread)
# Hardened, as Debian builds its own packages; PIE is its compiler's default. Sanitizers look at the
# same places themselves.
if(CMAKE_BUILD_TYPE STREQUAL "Release" AND NOT DCCAST_SANITIZE)
  add_compile_options(-fstack-protector-strong -D_FORTIFY_SOURCE=2)
  add_link_options(-Wl,-z,relro -Wl,-z,now)
endif()

# ccache, where there is one, makes a second build tree cheap. Without these permissions it refuses
# every file that is compiled with a precompiled header.
find_program(CCACHE_PROGRAM ccache)
if(CCACHE_PROGRAM)
  set(launcher ${CMAKE_COMMAND} -E env CCACHE_SLOPPINESS=pch_defines,time_macros ${CCACHE_PROGRAM})
  set(CMAKE_C_COMPILER_LAUNCHER ${launcher})
  set(CMAKE_CXX_COMPILER_LAUNCHER ${launcher})
endif()

add_library(dccast_options INTERFACE)
target_compile_options(dccast_options INTERFACE -Wall -Wextra -Wpedantic -Wshadow -Wconversion
  -Wno-sign-conversion)
if(DCCAST_SANITIZE)
  string(REPLACE "address" "address,undefined" kinds ${DCCAST_SANITIZE})
  # Undefined behaviour ends the program: a line on stderr fails no test.
  add_compile_options(-fsanitize=${kinds} -fno-sanitize-recover=all -fno-omit-frame-pointer)
  add_link_options(-fsanitize=${kinds})
  target_sources(dccast_options INTERFACE
    $<$<STREQUAL:$<TARGET_PROPERTY:TYPE>,EXECUTABLE>:${CMAKE_CURRENT_LIST_DIR}/sanitizer.cpp>)
endif()
if(DCCAST_FUZZ)
  add_compile_options(-fsanitize=fuzzer-no-link)  # counts what a text reaches: tests/fuzz
endif()
