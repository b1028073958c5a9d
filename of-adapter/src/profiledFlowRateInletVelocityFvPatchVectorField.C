/*---------------------------------------------------------------------------*\
    fsi-driver: adapter for OpenFOAM
\*---------------------------------------------------------------------------*/

#include "profiledFlowRateInletVelocityFvPatchVectorField.H"
#include "addToRunTimeSelectionTable.H"
#include "fvPatchFieldMapper.H"
#include "IFstream.H"
#include "volFields.H"

// * * * * * * * * * * * * * * * * Constructors  * * * * * * * * * * * * * * //

#define CLASS Foam::profiledFlowRateInletVelocityFvPatchVectorField
#define CONSTRUCTOR profiledFlowRateInletVelocityFvPatchVectorField

CLASS::CONSTRUCTOR
(
    const fvPatch& p,
    const DimensionedField<vector, volMesh>& iF
)
:
    fixedValueFvPatchVectorField(p, iF),
    flowRate_(),
    ramp_(),
    profile_(),
    frequency_(0),
    isRead_(false)
{}


CLASS::CONSTRUCTOR
(
    const fvPatch& p,
    const DimensionedField<vector, volMesh>& iF,
    const dictionary& dict
)
:
    fixedValueFvPatchVectorField(p, iF, dict, false),
    flowRate_(Function1<scalar>::New("volumetricFlowRate", dict)),
    ramp_(dict.found("ramp") ? Function1<scalar>::New("ramp", dict) : nullptr),
    profile_(dict.get<fileName>("profile")),
    frequency_(0),
    isRead_(false)
{
    if (dict.found("value"))
    {
        fvPatchField<vector>::operator=(vectorField("value", dict, p.size()));
    }
    else
    {
        fvPatchField<vector>::operator=(vector::zero);
    }
}


CLASS::CONSTRUCTOR
(
    const CONSTRUCTOR& other,
    const fvPatch& p,
    const DimensionedField<vector, volMesh>& iF,
    const fvPatchFieldMapper& mapper
)
:
    fixedValueFvPatchVectorField(other, p, iF, mapper),
    flowRate_(other.flowRate_.clone()),
    ramp_(other.ramp_.clone()),
    profile_(other.profile_),
    frequency_(0),
    isRead_(false)
{}


CLASS::CONSTRUCTOR(const CONSTRUCTOR& other)
:
    CONSTRUCTOR(other, other.internalField())
{}


CLASS::CONSTRUCTOR
(
    const CONSTRUCTOR& other,
    const DimensionedField<vector, volMesh>& iF
)
:
    fixedValueFvPatchVectorField(other, iF),
    flowRate_(other.flowRate_.clone()),
    ramp_(other.ramp_.clone()),
    profile_(other.profile_),
    frequency_(other.frequency_),
    rest_(other.rest_),
    terms_(other.terms_),
    isRead_(other.isRead_)
{}


// * * * * * * * * * * * * * * * Member Functions  * * * * * * * * * * * * * //

void CLASS::readProfile()
{
    fileName path(profile_);
    path.expand();
    IFstream stream(path);
    if (!stream.good())
    {
        FatalErrorInFunction
            << "Cannot read the profile of the inlet, " << path
            << exit(FatalError);
    }
    const dictionary dict(stream);
    frequency_ = dict.get<scalar>("frequency");
    const pointField points(dict.get<pointField>("points"));
    const scalarField rest(dict.get<scalarField>("rest"));
    const List<scalarField> terms(dict.get<List<scalarField>>("terms"));

    const vectorField& centres = patch().Cf();
    rest_.resize(centres.size());
    terms_.resize(terms.size());
    forAll(terms_, k)
    {
        terms_[k].resize(centres.size());
    }
    forAll(centres, face)
    {
        label nearest = -1;
        scalar least = GREAT;
        forAll(points, i)
        {
            const scalar distance = magSqr(points[i] - centres[face]);
            if (distance < least)
            {
                least = distance;
                nearest = i;
            }
        }
        if (nearest < 0 || least > 1e-6*patch().magSf()[face])
        {
            FatalErrorInFunction
                << "The profile of the inlet in " << path
                << " has no point at the face centre " << centres[face]
                << exit(FatalError);
        }
        rest_[face] = rest[nearest];
        forAll(terms_, k)
        {
            terms_[k][face] = terms[k][nearest];
        }
    }
    isRead_ = true;
}


void CLASS::updateCoeffs()
{
    if (updated())
    {
        return;
    }
    if (!isRead_)
    {
        readProfile();
    }
    const scalar t = db().time().timeOutputValue();
    const scalar factor = ramp_ ? ramp_->value(t) : 1;

    scalarField velocity(patch().size(), Zero);
    forAll(terms_, k)
    {
        // 1, then cosine and sine of each harmonic
        const scalar phase = ((k + 1)/2)*frequency_*t;
        const scalar b = k == 0 ? 1 : (k % 2 ? std::cos(phase) : std::sin(phase));
        velocity += factor*b*terms_[k];
    }
    const scalarField& areas = patch().magSf();
    const scalar lacking = flowRate_->value(t) - gSum(velocity*areas);
    velocity += rest_*(lacking/gSum(rest_*areas));

    operator==(-velocity*patch().nf());
    fixedValueFvPatchVectorField::updateCoeffs();
}


void CLASS::write(Ostream& os) const
{
    fvPatchVectorField::write(os);
    flowRate_->writeData(os);
    if (ramp_)
    {
        ramp_->writeData(os);
    }
    os.writeEntry("profile", profile_);
    writeEntry("value", os);
}


namespace Foam
{
    makePatchTypeField
    (
        fvPatchVectorField,
        profiledFlowRateInletVelocityFvPatchVectorField
    );
}


// ************************************************************************* //
