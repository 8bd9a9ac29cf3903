// VTKHDF reader; see vtkhdf.hpp.
#include <string>
#include <vector>

#include "core/base/error.hpp"
#include "core/frame/quantities.hpp"
#include "core/io/hdf5_handle.hpp"
#include "core/io/vtkhdf.hpp"

namespace talus {

struct VtkHdfReader::Impl {
  std::string path;
  Handle file;
  std::vector<Step> steps;
  std::vector<std::int64_t> first, count;  ///< points of each frame

  template <class T>
  std::vector<T> read(const std::string& name, hid_t memory, hsize_t from, hsize_t rows, hsize_t width) const {
    const auto fail = [&](const char* why) {
      throw Error(ErrorCode::io, "cannot read '" + name + "': " + why, path, "particles.vtkhdf of a run is expected");
    };
    std::vector<T> out(rows * width);
    const Handle data(H5Dopen2(file, name.c_str(), H5P_DEFAULT));
    if (data < 0) fail("it is not there");
    const Handle space(H5Dget_space(data));
    const int rank = H5Sget_simple_extent_ndims(space);
    hsize_t size[2] = {0, 1};
    if (rank < 1 || rank > 2 || H5Sget_simple_extent_dims(space, size, nullptr) < 0) fail("it has another shape");
    if (size[1] != width || from + rows > size[0]) fail("it has another shape");
    if (rows == 0) return out;
    const hsize_t start[2] = {from, 0}, n[2] = {rows, width};
    const Handle target(H5Screate_simple(rank, n, nullptr));
    if (H5Sselect_hyperslab(space, H5S_SELECT_SET, start, nullptr, n, nullptr) < 0 ||
        H5Dread(data, memory, target, space, H5P_DEFAULT, out.data()) < 0)
      fail("damaged");
    return out;
  }

  /// Columns that hold one double for each point and that no table here knows, by name.
  std::vector<std::string> columns_of_parts() const {
    std::vector<std::string> names;
    const Handle group(H5Gopen2(file, "/VTKHDF/PointData", H5P_DEFAULT));
    const auto keep = [](hid_t in, const char* name, const H5L_info_t*, void* to) -> herr_t {
      const Handle data(H5Dopen2(in, name, H5P_DEFAULT));
      const Handle type(data < 0 ? -1 : H5Dget_type(data)), space(data < 0 ? -1 : H5Dget_space(data));
      if (data >= 0 && H5Sget_simple_extent_ndims(space) == 1 && H5Tequal(type, H5T_IEEE_F64LE) > 0 &&
          is_part_column(name))
        static_cast<std::vector<std::string>*>(to)->emplace_back(name);
      return 0;
    };
    if (group >= 0) H5Literate(group, H5_INDEX_NAME, H5_ITER_INC, nullptr, keep, &names);
    return names;
  }
};

VtkHdfReader::VtkHdfReader(const std::string& path) : impl_(std::make_unique<Impl>()) {
  quiet_library();
  Impl& m = *impl_;
  m.path = path;
  const Handle access(H5Pcreate(H5P_FILE_ACCESS));
  H5Pset_file_locking(access, false, true);
  m.file = Handle(H5Fopen(path.c_str(), H5F_ACC_RDONLY, access));
  if (m.file < 0) throw Error(ErrorCode::io, "cannot open as HDF5", path, "particles.vtkhdf of a run is expected");
  std::int64_t frames = 0;
  {
    const Handle group(H5Gopen2(m.file, "/VTKHDF/Steps", H5P_DEFAULT));
    const Handle count(group < 0 ? -1 : H5Aopen(group, "NSteps", H5P_DEFAULT));
    if (count < 0 || H5Aread(count, H5T_NATIVE_INT64, &frames) < 0 || frames < 0)
      throw Error(ErrorCode::io, "has no steps", path, "particles.vtkhdf of a run is expected");
  }
  const auto n = static_cast<hsize_t>(frames);
  const auto step = m.read<std::int64_t>("/talus/step", H5T_NATIVE_INT64, 0, n, 1);
  const auto time = m.read<double>("/VTKHDF/Steps/Values", H5T_NATIVE_DOUBLE, 0, n, 1);
  m.first = m.read<std::int64_t>("/VTKHDF/Steps/PointOffsets", H5T_NATIVE_INT64, 0, n, 1);
  m.count = m.read<std::int64_t>("/VTKHDF/NumberOfPoints", H5T_NATIVE_INT64, 0, n, 1);
  for (std::size_t k = 0; k < n; ++k) m.steps.push_back({step[k], time[k]});
}

VtkHdfReader::VtkHdfReader(VtkHdfReader&&) noexcept = default;
VtkHdfReader::~VtkHdfReader() = default;
const std::vector<VtkHdfReader::Step>& VtkHdfReader::steps() const noexcept { return impl_->steps; }

Frame VtkHdfReader::frame(std::size_t k) const {
  const Impl& m = *impl_;
  const auto from = static_cast<hsize_t>(m.first[k]), n = static_cast<hsize_t>(m.count[k]);
  Frame f;
  f.step = m.steps[k].step;
  f.time = m.steps[k].time;
  f.x = vectors_of(m.read<double>("/VTKHDF/Points", H5T_NATIVE_DOUBLE, from, n, 3));
  for (const ParticleQuantity& q : particle_quantities()) {
    const std::string name = "/VTKHDF/PointData/" + std::string(q.name);
    if (q.take == nullptr || (q.wanted != nullptr && H5Lexists(m.file, name.c_str(), H5P_DEFAULT) <= 0)) continue;
    ColumnValues values = q.values(Frame{});  // none, of the right type
    const hid_t memory = native_type(values);
    std::visit(
        [&](auto& v) {
          using T = typename std::remove_reference_t<decltype(v)>::value_type;
          v = m.read<T>(name, memory, from, n, static_cast<hsize_t>(q.components));
        },
        values);
    q.take(f, std::move(values));
  }
  for (const std::string& name : m.columns_of_parts())
    f.extra.push_back({name, "", m.read<double>("/VTKHDF/PointData/" + name, H5T_NATIVE_DOUBLE, from, n, 1)});
  // such a file holds the spheres of bodies, not how the bodies lie
  f.bodies_missing = H5Lexists(m.file, "/VTKHDF/PointData/body", H5P_DEFAULT) > 0;
  return f;
}

}  // namespace talus
