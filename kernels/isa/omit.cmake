# Takes the units of instruction sets that TALUS_ISAS leaves out from kernel_sources, and adds a unit of empty tables in
# their place; the choice at run time then offers only what was built.
set(omitted "")
foreach(unit ${kernel_sources})
  if(NOT unit MATCHES "/isa/(isa|bodies|grains)_([a-z0-9]+)(_fast)?\\.cpp$")
    continue()
  endif()
  set(kind ${CMAKE_MATCH_1})
  set(name ${CMAKE_MATCH_2}${CMAKE_MATCH_3})
  if("${CMAKE_MATCH_2}" IN_LIST TALUS_ISAS AND (NOT CMAKE_MATCH_3 OR "fast" IN_LIST TALUS_ISAS))
    continue()
  endif()
  list(REMOVE_ITEM kernel_sources ${unit})
  if(kind STREQUAL "isa")
    string(APPEND omitted "extern const KernelTable k_table_${name};\nconstinit const KernelTable k_table_${name}{};\n")
  elseif(kind STREQUAL "bodies")
    string(APPEND omitted "extern const PairSolver k_pair_solver_${name};\nconstinit const PairSolver k_pair_solver_${name} = nullptr;\n"
           "extern const PairGaps k_pair_gaps_${name};\nconstinit const PairGaps k_pair_gaps_${name} = nullptr;\n"
           "extern const BodyMover k_body_mover_${name};\nconstinit const BodyMover k_body_mover_${name} = nullptr;\n")
  else()
    string(APPEND omitted "extern const GrainSolver k_grain_solver_${name};\nconstinit const GrainSolver k_grain_solver_${name} = nullptr;\n")
  endif()
endforeach()
if(omitted)
  file(CONFIGURE OUTPUT ${CMAKE_BINARY_DIR}/generated/omitted.cpp CONTENT
"#include \"kernels/bodies/motion_batch.hpp\"
#include \"kernels/bodies/pair_batch.hpp\"
#include \"kernels/conversion/grain_batch.hpp\"
#include \"kernels/kernel_table.hpp\"

namespace talus {
${omitted}}
")
  list(APPEND kernel_sources ${CMAKE_BINARY_DIR}/generated/omitted.cpp)
endif()
foreach(set ${TALUS_ISAS})
  if(NOT set MATCHES "^(scalar|sse2|avx2|avx512|fast)$")
    message(FATAL_ERROR "TALUS_ISAS: ${set}; allowed: scalar, sse2, avx2, avx512, fast")
  endif()
endforeach()
if(NOT TALUS_ISAS MATCHES "scalar|sse2|avx")
  message(FATAL_ERROR "TALUS_ISAS: no instruction set; allowed: scalar, sse2, avx2, avx512")
endif()
