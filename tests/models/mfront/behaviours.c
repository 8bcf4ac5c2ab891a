/* Behaviours with the generic interface of MFront, written by hand for the tests: what TFEL would have made of them.

   Maxwell: elasticity whose deviator relaxes, implicit in time. Properties: Young's modulus, Poisson's ratio, RelaxationTime,
   which the external state variable Factor multiplies. State: elastic strain, ViscousStrain (equivalent).
   Troubled: elasticity that fails as its property Mode says.
   Large, Orthotropic, PlaneOnly, Other: what is no soil law here. */

#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct {
  double *gradients, *forces, *density, *properties, *state, *stored_energy, *dissipated_energy, *external;
} State;

typedef struct {
  char *error_message;
  double dt;
  double *K;
  double *rdt;
  double *speed_of_sound;
  State s0, s1;
} Data;

#define NAMES(behaviour, what, count, ...)            \
  unsigned short behaviour##_n##what = count;         \
  const char *behaviour##_##what[] = {__VA_ARGS__};

#define BEHAVIOUR(behaviour, kind, symmetry, gradient, force)     \
  const char *behaviour##_mfront_ept = #behaviour;                \
  const char *behaviour##_mfront_interface = "Generic";           \
  const char *behaviour##_tfel_version = "4.2";                   \
  unsigned short behaviour##_BehaviourType = kind;                \
  unsigned short behaviour##_SymmetryType = symmetry;             \
  unsigned short behaviour##_ElasticSymmetryType = 0;             \
  unsigned short behaviour##_requiresStiffnessTensor = 1;         \
  NAMES(behaviour, Gradients, 1, gradient)                        \
  NAMES(behaviour, ThermodynamicForces, 1, force)                 \
  NAMES(behaviour, TangentOperatorBlocks, 2, force, gradient)

static double traced(const double *tensor) { return tensor[0] + tensor[1] + tensor[2]; }

/* Elasticity, the deviator of the elastic strain multiplied by r; the equivalent of what it lost. */
static double respond(const Data *d, int n, double r) {
  const double E = d->s1.properties[0], nu = d->s1.properties[1];
  const double bulk = E / (3 * (1 - 2 * nu)), shear = E / (2 * (1 + nu));
  double strain[6], norm = 0;
  for (int i = 0; i < n; ++i) strain[i] = d->s0.state[i] + d->s1.gradients[i] - d->s0.gradients[i];
  const double volume = traced(strain);
  for (int i = 0; i < n; ++i) {
    const double part = i < 3 ? volume / 3 : 0, deviator = strain[i] - part;
    norm += deviator * deviator;
    d->s1.state[i] = r * deviator + part;
    d->s1.forces[i] = 2 * shear * r * deviator + 3 * bulk * part;
  }
  if (d->K[0] == 4)
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j)
        d->K[n * i + j] = 2 * shear * r * (i == j) + (i < 3 && j < 3 ? bulk - 2 * shear * r / 3 : 0);
  return (1 - r) * sqrt(2.0 / 3.0 * norm);
}

static int maxwell(Data *d, int n) {
  const double time = d->s1.properties[2] * d->s1.external[1];
  d->s1.state[n] = d->s0.state[n] + respond(d, n, 1 / (1 + d->dt / time));
  return 1;
}

BEHAVIOUR(Maxwell, 1, 0, "Strain", "Stress")
NAMES(Maxwell, MaterialProperties, 1, "RelaxationTime")
NAMES(Maxwell, InternalStateVariables, 2, "ElasticStrain", "ViscousStrain")
NAMES(Maxwell, ExternalStateVariables, 1, "Factor")
int Maxwell_InternalStateVariablesTypes[] = {1, 0};
int Maxwell_ExternalStateVariablesTypes[] = {0};
long double Maxwell_YoungModulus_LowerPhysicalBound = 0;
long double Maxwell_PoissonRatio_LowerPhysicalBound = -1;
long double Maxwell_PoissonRatio_UpperPhysicalBound = 0.5;
int Maxwell_Tridimensional(Data *d) { return maxwell(d, 6); }
int Maxwell_PlaneStrain(Data *d) { return maxwell(d, 4); }
int Maxwell_Axisymmetrical(Data *d) { return maxwell(d, 4); }

static int troubled(Data *d, int n) {
  const int mode = (int)d->s1.properties[2];
  double moved = 0;
  for (int i = 0; i < n; ++i) moved += fabs(d->s1.gradients[i] - d->s0.gradients[i]);
  respond(d, n, 1);
  if (moved == 0) return 1;
  if (mode == 1) {
    strcpy(d->error_message, "no convergence after 100 rounds");
    return -1;
  }
  if (mode == 2) return 0;
  if (mode == 3) d->s1.forces[1] = NAN;
  if (mode == 4) d->K[n + 1] = INFINITY;
  if (mode == 5) d->s1.state[2] = NAN;
  if (mode == 6) abort();
  return 1;
}

BEHAVIOUR(Troubled, 1, 0, "Strain", "Stress")
NAMES(Troubled, MaterialProperties, 1, "Mode")
NAMES(Troubled, InternalStateVariables, 1, "ElasticStrain")
int Troubled_InternalStateVariablesTypes[] = {1};
int Troubled_Tridimensional(Data *d) { return troubled(d, 6); }
int Troubled_PlaneStrain(Data *d) { return troubled(d, 4); }

BEHAVIOUR(Large, 2, 0, "DeformationGradient", "FirstPiolaKirchhoffStress")
int Large_Tridimensional(Data *d) { return maxwell(d, 6); }

BEHAVIOUR(Orthotropic, 1, 1, "Strain", "Stress")
int Orthotropic_Tridimensional(Data *d) { return maxwell(d, 6); }

BEHAVIOUR(PlaneOnly, 1, 0, "Strain", "Stress")
int PlaneOnly_PlaneStress(Data *d) { return maxwell(d, 4); }

const char *Other_mfront_ept = "Other";
const char *Other_mfront_interface = "Abaqus";

BEHAVIOUR(Indexed, 1, 0, "Strain", "Stress")
NAMES(Indexed, MaterialProperties, 2, "Normals[0]", "q")
int Indexed_Tridimensional(Data *d) { return maxwell(d, 6); }

BEHAVIOUR(Tensorial, 1, 0, "Strain", "Stress")
NAMES(Tensorial, InternalStateVariables, 1, "Deformation")
int Tensorial_InternalStateVariablesTypes[] = {3};
int Tensorial_Tridimensional(Data *d) { return maxwell(d, 6); }

BEHAVIOUR(Lengthy, 1, 0, "Strain", "Stress")
unsigned short Lengthy_nInternalStateVariables = 21;
#define SIX(what) #what "0", #what "1", #what "2", #what "3", #what "4", #what "5"
const char *Lengthy_InternalStateVariables[] = {SIX(a), SIX(b), SIX(c), "d0", "d1", "d2"};
int Lengthy_InternalStateVariablesTypes[] = {1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1};
int Lengthy_Tridimensional(Data *d) { return maxwell(d, 6); }
