"""What is too weak to be modelled in materials of other programs' files.

A lobe that returns 5 % makes a solve take 20 times as long; counted as diffuse reflectance it
changes the irradiance by 0.5 % (median, benchmarks/weak.md). Scene files can ask for less.
"""

WEAK = 0.05  # a share of light up to which no highlight, mirror or pane is modelled
