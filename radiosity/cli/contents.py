"""What a scene's files hold, as ``radiosity info --json`` tells it."""

from radiosity.cli.answer import solved


def facts(scene, solution=None) -> dict:
    """Return all of a scene's contents as plain values; of a solution also how it was solved."""
    faces, vertices = scene.faces, scene.faces.vertices.reshape(-1, 3)
    triangles = int(faces.is_triangle.sum())
    return {
        "name": scene.name,
        "unit": scene.unit,
        "up": scene.up,
        "triangles": triangles,
        "quadrilaterals": len(faces) - triangles,
        "curved_faces": int(faces.is_curved.sum()),
        "area_m2": float(faces.areas().sum()) * scene.unit_m**2,
        "low": vertices.min(axis=0),
        "high": vertices.max(axis=0),
        "bands": list(scene.bands.names),
        "wavelengths_nm": scene.bands.wavelengths,
        "materials": _materials(scene),
        "lights": _lights(scene),
        "ambient": scene.ambient,
        "cameras": [_camera(camera) for camera in scene.cameras.values()],
        **_mesh(scene),
        "truth": scene.truth and {
            "mesh": scene.truth.mesh, "tolerance": scene.truth.relative_tolerance,
        },
        "read_as": {name: said.origin for name, said in scene.read_as.items()},
        "notes": list(scene.notes),
        "solved": solution and {
            **solved(solution), "light_groups": list(solution.groups),
            "can_dim": solution.can_dim,
        },
    }  # fmt: skip


def _mesh(scene) -> dict:
    from radiosity.mesh.findings import MEANS
    from radiosity.scene.contents import flaws_of

    contacts, flaws = flaws_of(scene)
    return {
        "contacts": len(contacts),
        "covered_faces": sum(bool(c.covers or c.hides) for c in contacts.values()),
        "closed_looking_out": flaws.outward,
        "closed_looking_in": flaws.inward,
        "open": flaws.open,
        "findings": [
            {
                "kind": f.kind, "count": f.count, "means": MEANS[f.kind], "faces": f.faces,
                "groups": [scene.groups[scene.faces.group[k]] for k in f.faces],
                "points": f.points,
            }
            for f in flaws.found
        ],
    }  # fmt: skip


def _materials(scene) -> list[dict]:
    area = scene.faces.areas() * scene.unit_m**2
    return [
        {
            "name": m.name, "faces": int((scene.faces.material == k).sum()),
            "area_m2": float(area[scene.faces.material == k].sum()), "diffuse": m.diffuse,
            "emission": m.emission, "two_sided": m.two_sided,
            "specular": m.specular and m.specular.summary,
            "mirror": m.mirror and m.mirror.summary,
            "transmit": m.transmit and m.transmit.summary,
            "translucent": m.translucent, "absorption": m.absorption,
            "textured": m.texture is not None, "bumps": m.bump is not None,
        }
        for k, m in enumerate(scene.materials)
    ]  # fmt: skip


def _lights(scene) -> list[dict]:
    from radiosity.light.photometry import photometric
    from radiosity.scene.groups import groups_of_lights, kind_of_light

    found = []
    for light, group in zip(scene.lights, groups_of_lights(scene), strict=True):
        label = getattr(light, "label", "") or None
        peak = float(photometric(light.strength, scene.bands)) if label else None
        found.append({
            "type": kind_of_light(light), "group": group,
            "position": getattr(light, "position", None),
            "direction": getattr(light, "direction", None), "strength": light.strength,
            "read_as": label, "peak_cd": peak,
            "flux_lm": peak * float(light.solid_angle) if label else None,
        })  # fmt: skip
    return found


def _camera(camera) -> dict:
    flat = camera.orthographic
    return {
        "name": camera.name, "position": camera.position, "target": camera.target,
        "up": camera.up, "fov": None if flat else camera.fov,
        "height": camera.height if flat else None, "size": camera.size,
    }  # fmt: skip
