"""Pictures of spheres and walls: an orthographic z-buffer renderer on numpy, walls as translucent outlines.

Used by draw.py. Every sphere has its true size; shading is by surface normal plus depth darkening (a pixel that lies
behind its neighbourhood gets darker), which makes a bed readable without shadows. 500k spheres take a few seconds.
"""
import numpy as np

SUPERSAMPLING = 2


class Camera:
    """Orthographic view along a horizontal direction turned by azimuth, raised by elevation [degrees]; z is up."""

    def __init__(self, azimuth, elevation):
        a, e = np.radians(azimuth), np.radians(elevation)
        self.right = np.array([np.cos(a), np.sin(a), 0.0])
        self.towards = np.array([np.sin(a) * np.cos(e), -np.cos(a) * np.cos(e), np.sin(e)])
        self.up = np.cross(self.towards, self.right)

    def project(self, points):
        """Columns: right, up, towards the viewer."""
        return np.asarray(points) @ np.stack([self.right, self.up, self.towards], 1)

    @staticmethod
    def for_bounds(lower, upper):
        """Looks across the thin direction of a slice, at three quarters otherwise."""
        size = np.maximum(np.asarray(upper) - np.asarray(lower), 1e-300)
        if size[1] < 0.25 * size[0]:
            return Camera(10, 8)
        if size[0] < 0.25 * size[1]:
            return Camera(80, 8)
        return Camera(28, 14)


def splat(centres, radii, values, frame, width, normals):
    """Depth, value and light per pixel of the nearest sphere; frame = (left, right, bottom, top), and the normals that are
    not nan replace the sphere's own; both in view coordinates."""
    left, right, bottom, top = frame
    pixel = (right - left) / width
    height = max(1, int(np.ceil((top - bottom) / pixel)))
    depth = np.full(width * height, -np.inf)
    colour = np.full(width * height, np.nan)
    light = np.zeros(width * height)
    u, v = (centres[:, 0] - left) / pixel, (top - centres[:, 1]) / pixel
    r = np.maximum(radii / pixel, 0.6)  # never smaller than a pixel
    seen = (u > -r) & (u < width + r) & (v > -r) & (v < height + r)
    direction = np.array([-0.35, 0.55, 0.76])  # of the light, in view coordinates
    direction /= np.linalg.norm(direction)
    reach = np.ceil(r).astype(int)
    for size in np.unique(reach[seen]):
        span = np.arange(-size, size + 1)
        du, dv = (a.ravel() for a in np.meshgrid(span, span))
        keep = du * du + dv * dv <= (size + 1) ** 2
        du, dv = du[keep], dv[keep]
        members = np.flatnonzero(seen & (reach == size))
        step = max(1, 4_000_000 // len(du))
        for start in range(0, len(members), step):
            m = members[start : start + step]
            x = np.floor(u[m])[:, None] + du
            y = np.floor(v[m])[:, None] + dv
            nx, ny = (x + 0.5 - u[m][:, None]) / r[m][:, None], (v[m][:, None] - y - 0.5) / r[m][:, None]
            rim = 1 - nx * nx - ny * ny
            hit = (rim > 0) & (x >= 0) & (x < width) & (y >= 0) & (y < height)
            row = np.broadcast_to(m[:, None], hit.shape)[hit]
            nz = np.sqrt(rim[hit])
            z = centres[row, 2] + nz * r[row] * pixel
            at = (y[hit] * width + x[hit]).astype(np.int64)
            nearer = z > depth[at]
            order = np.flatnonzero(nearer)[np.argsort(z[nearer], kind="stable")]  # last write wins: the nearest
            at = at[order]
            depth[at] = z[order]
            colour[at] = values[row[order]]
            own = nx[hit][order] * direction[0] + ny[hit][order] * direction[1] + nz[order] * direction[2]
            given = normals[row[order]] @ direction
            light[at] = np.where(np.isnan(given), own, given)
    shape = (height, width)
    return depth.reshape(shape), colour.reshape(shape), light.reshape(shape)


def box_blur(image, size):
    """Mean over (2 size + 1)^2 pixels, edges repeated."""
    for axis in (0, 1):
        padded = np.pad(image, [(size + 1, size) if a == axis else (0, 0) for a in (0, 1)], mode="edge")
        sums = np.cumsum(padded, axis=axis)
        n = image.shape[axis]
        upper, lower = np.take(sums, range(2 * size + 1, n + 2 * size + 1), axis), np.take(sums, range(n), axis)
        image = (upper - lower) / (2 * size + 1)
    return image


def picture(points, radii, values, camera, frame, width, colours, normals=None, scale=None):
    """RGBA image (float, 0..1) of the spheres; transparent where there is none. `colours` maps values to RGBA; normals: see
    bodies.dressed(); scale: size of a grain [m], by default the median radius."""
    width *= SUPERSAMPLING
    if len(points) == 0:
        ratio = (frame[3] - frame[2]) / (frame[1] - frame[0])
        return np.zeros((max(1, int(width * ratio)) // SUPERSAMPLING, width // SUPERSAMPLING, 4))
    turned = np.full((len(points), 3), np.nan) if normals is None else camera.project(normals)
    depth, colour, light = splat(camera.project(points), radii, values, frame, width, turned)
    covered = np.isfinite(depth)
    rgba = np.zeros(depth.shape + (4,))
    rgba[covered] = colours(colour[covered])
    shade = 0.58 + 0.50 * np.clip(light, 0, 1)
    # Depth darkening: how far a pixel lies behind the mean of its neighbourhood, in grain radii.
    scale = np.median(radii) if scale is None else scale
    z = np.where(covered, depth, depth[covered].min() if covered.any() else 0.0)
    size = int(np.clip(1.5 * scale / (frame[1] - frame[0]) * width, 2, 40))
    behind = np.clip((box_blur(box_blur(z, size), size) - z) / (2.5 * scale), 0, 1)
    shade *= 1 - 0.45 * behind
    gloss = 0.18 * np.clip(light, 0, 1) ** 24
    rgba[..., :3] = np.clip(rgba[..., :3] * shade[..., None] + gloss[..., None] * covered[..., None], 0, 1)
    rgba[..., 3] = covered
    # Down to the wanted size with colours weighted by coverage, so that edges blend into the page.
    h, w = (n // SUPERSAMPLING * SUPERSAMPLING for n in rgba.shape[:2])
    blocks = rgba[:h, :w].reshape(h // SUPERSAMPLING, SUPERSAMPLING, w // SUPERSAMPLING, SUPERSAMPLING, 4)
    alpha = blocks[..., 3:].sum((1, 3))
    small = (blocks[..., :3] * blocks[..., 3:]).sum((1, 3)) / np.maximum(alpha, 1)
    return np.concatenate([small, alpha / SUPERSAMPLING**2], axis=2)


def outlines(points, triangles, camera=None):
    """Segments (n, 2, 2) in view coordinates: borders, creases of 25 degrees and more, and silhouettes. Without a camera
    segments (n, 2, 3) in space, without silhouettes."""
    points, triangles = np.asarray(points, float), np.asarray(triangles, int)
    none = np.zeros((0, 2, 2 if camera else 3))
    if len(triangles) == 0:
        return none
    # STL facets repeat their corners: merge equal points first.
    extent = max(np.ptp(points, axis=0).max(), 1e-300)
    merged, index = np.unique(np.round(points / extent, 7), axis=0, return_inverse=True)
    tri = index.reshape(-1)[triangles]
    tri = tri[(tri[:, 0] != tri[:, 1]) & (tri[:, 1] != tri[:, 2]) & (tri[:, 2] != tri[:, 0])]
    if len(tri) == 0:
        return none
    corner = merged[tri]
    normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    normal /= np.maximum(np.linalg.norm(normal, axis=1), 1e-300)[:, None]
    edges = np.concatenate([tri[:, [0, 1]], tri[:, [1, 2]], tri[:, [2, 0]]])
    face = np.tile(np.arange(len(tri)), 3)
    direction = np.sign(edges[:, 1] - edges[:, 0])  # facets of one orientation run along a shared edge oppositely
    edges = np.sort(edges, axis=1)
    order = np.lexsort((edges[:, 1], edges[:, 0]))
    edges, face, direction = edges[order], face[order], direction[order]
    first = np.concatenate([[True], np.any(edges[1:] != edges[:-1], axis=1)])
    starts = np.flatnonzero(first)
    counts = np.diff(np.append(starts, len(edges)))
    draw = counts != 2
    two = starts[counts == 2]
    a, b = face[two], face[two + 1]
    flip = np.where(direction[two] == direction[two + 1], -1.0, 1.0)
    cosine = np.einsum("ij,ij->i", normal[a], normal[b]) * flip
    creased = cosine < np.cos(np.radians(25))
    if camera:
        facing = (normal[a] @ camera.towards) * (normal[b] @ camera.towards) * flip
        creased |= (facing < -1e-9) & (cosine < 1 - 1e-9)
    draw[counts == 2] = creased
    chosen = edges[starts[draw]]
    return (camera.project(merged * extent)[:, :2] if camera else merged * extent)[chosen]
