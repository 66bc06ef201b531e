"""Materials of MaterialX, from files of their own (.mtlx) and from stages of OpenUSD.

A network of nodes is the same in both: `nodes` holds it, `document` builds it from a file and
`alight.formats.usd.networks` from a stage. `evaluate` turns it into numbers and textures, and
`shaders` what its surface shader says into a `Surface`, as for all formats. What is covered is
listed in docs/materialx.md.

Source: MaterialX specification, versions 1.38 and 1.39 (materialx.org), with its standard library
for the defaults and the meaning of each node.
"""
