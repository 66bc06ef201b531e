"""All planted bugs, in the order in which they are tried."""

from tests.mutants.agreement import AGREEMENT
from tests.mutants.behind_glass import BEHIND_GLASS
from tests.mutants.beyond_examples import BEYOND_EXAMPLES
from tests.mutants.bodies import BODIES
from tests.mutants.both_ends import BOTH_ENDS
from tests.mutants.cluster import CLUSTER
from tests.mutants.coloured_glass import COLOURED_GLASS
from tests.mutants.compiler import COMPILER
from tests.mutants.dispersed import DISPERSED
from tests.mutants.displacement import DISPLACEMENT
from tests.mutants.edges import EDGES
from tests.mutants.emission import EMISSION
from tests.mutants.everyday import EVERYDAY
from tests.mutants.facets import FACETS
from tests.mutants.film import FILM
from tests.mutants.foreign import FOREIGN
from tests.mutants.formats import FORMATS
from tests.mutants.foundations import FOUNDATIONS
from tests.mutants.gpu import GPU
from tests.mutants.graphs import GRAPHS
from tests.mutants.guiding import GUIDING
from tests.mutants.known_error import KNOWN_ERROR
from tests.mutants.laboratory import LABORATORY
from tests.mutants.laid_down import LAID_DOWN
from tests.mutants.lamp_maps import LAMP_MAPS
from tests.mutants.large_pictures import LARGE_PICTURES
from tests.mutants.laws import LAWS
from tests.mutants.lights import LIGHT
from tests.mutants.manifolds import MANIFOLDS
from tests.mutants.materials import COATED, MATERIALS, TEXTURES
from tests.mutants.mattes import MATTES
from tests.mutants.media import MEDIA
from tests.mutants.objects import OBJECTS
from tests.mutants.one_of_two import ONE_OF_TWO
from tests.mutants.outer import OUTER
from tests.mutants.principled import PRINCIPLED
from tests.mutants.random_scenes import RANDOM_SCENES
from tests.mutants.rays import RAYS
from tests.mutants.readers import READERS
from tests.mutants.rendering_space import RENDERING_SPACE
from tests.mutants.scattering import SCATTERING
from tests.mutants.shadows import SHADOWS
from tests.mutants.shown_again import SHOWN_AGAIN
from tests.mutants.slips import SLIPS
from tests.mutants.strands import STRANDS
from tests.mutants.studies import STUDIES
from tests.mutants.training import TRAINING
from tests.mutants.transport import TRANSPORT
from tests.mutants.turned import TURNED
from tests.mutants.view import VIEW
from tests.mutants.walks import WALKS
from tests.mutants.waves import WAVES

MUTANTS = (
    SCATTERING
    + LIGHT
    + GPU
    + LAMP_MAPS
    + EMISSION
    + BOTH_ENDS
    + COLOURED_GLASS
    + TRANSPORT
    + RAYS
    + FILM
    + MATTES
    + SHADOWS
    + DISPLACEMENT
    + DISPERSED
    + FACETS
    + TEXTURES
    + MATERIALS
    + COATED
    + PRINCIPLED
    + MEDIA
    + BODIES
    + TURNED
    + KNOWN_ERROR
    + BEHIND_GLASS
    + LABORATORY
    + LARGE_PICTURES
    + EDGES
    + RANDOM_SCENES
    + AGREEMENT
    + STUDIES
    + COMPILER
    + LAWS
    + WAVES
    + RENDERING_SPACE
    + MANIFOLDS
    + WALKS
    + GUIDING
    + TRAINING
    + FORMATS
    + VIEW
    + CLUSTER
    + OBJECTS
    + SHOWN_AGAIN
    + SLIPS
    + FOUNDATIONS
    + STRANDS
    + EVERYDAY
    + FOREIGN
    + READERS
    + GRAPHS
    + LAID_DOWN
    + BEYOND_EXAMPLES
    + ONE_OF_TWO
    + OUTER
)
