"""Files that are whole or absent, under the name that pictures and exports know them by."""

from radiosity.transport.files import check_place, written_whole

__all__ = ["check_place", "written_whole"]
